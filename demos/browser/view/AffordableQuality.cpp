// SPDX-License-Identifier: Zlib
#include "demos/browser/view/AffordableQuality.h"

#include <algorithm>
#include <iterator>

namespace browser
{
namespace
{
// The two limits differ by more than most steps of the ladder, so that a raised quality seldom proves too slow at once.
constexpr double kTooLong = 1.0 / 12, kFast = 1.0 / 40;  // [s]
constexpr int kPatience = 60, kMostCaution = 64;

/// Qualities from best to worst. The least visible part is reduced first: pixels, and spheres of hardly a pixel, then shadows.
constexpr RenderQuality kLadder[] = {
	{1, 2, 1024, false, 1.0 / 3}, {0.7, 2, 1024, false, 1}, {0.5, 1, 512, false, 1}, {0.5, 0, 512, false, 1}, {0.35, 0, 512, false, 1}};
}  // namespace

void AffordableQuality::took(double seconds)
{
	m_slow = seconds > kTooLong ? m_slow + 1 : 0;
	m_fast = seconds < kFast ? m_fast + 1 : 0;
	// The raised quality is fast enough.
	if (m_tookBack && m_fast >= kPatience) m_caution = 1;
	// A single slow picture may have any cause.
	if (m_slow >= 2) turn(1);
	else if (m_fast >= m_caution * kPatience) turn(-1);
}

void AffordableQuality::turn(int by)
{
	if (m_tookBack && by > 0) m_caution = std::min(2 * m_caution, kMostCaution);
	const int before = m_rung;
	m_rung = std::clamp(m_rung + by, 0, int(std::size(kLadder)) - 1);
	m_tookBack = m_rung < before;
	m_slow = m_fast = 0;
}

RenderQuality AffordableQuality::quality() const { return kLadder[m_rung]; }
}  // namespace browser
