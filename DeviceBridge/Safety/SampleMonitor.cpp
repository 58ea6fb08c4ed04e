// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Safety/SampleMonitor.h"

#include <algorithm>
#include <cmath>

namespace devicebridge
{
namespace
{
bool samePose(const ist::Pose& a, const ist::Pose& b)
{
	return a.translation == b.translation && a.rotation.row(0) == b.rotation.row(0) && a.rotation.row(1) == b.rotation.row(1) &&
		a.rotation.row(2) == b.rotation.row(2);
}

/// The angle between two orientations, from the Frobenius norm of their difference, which is sqrt(8) sin(angle / 2) [rad].
double turnBetween(const ist::Mat3& a, const ist::Mat3& b)
{
	double sum = 0;
	for (int i = 0; i < 3; ++i) sum += squaredNorm(a.row(i) - b.row(i));
	return 2 * std::asin(std::min(1.0, std::sqrt(sum / 8)));
}
}  // namespace

// A handle at rest also repeats its pose, but then its twist is zero and its sequence grows.
bool SampleMonitor::repeats(const DeviceState& state) const noexcept
{
	const bool sameNumber = state.sequence != 0 && state.sequence == m_last.sequence;
	if (sameNumber || state.sampledAt == m_last.sampledAt) return true;
	return !state.velocityEstimated && norm(state.twist.linear) > m_settings.movingSpeed && samePose(state.X_WH, m_last.X_WH);
}

bool SampleMonitor::turnsInPlace(const DeviceState& state, std::int64_t now) noexcept
{
	if (!m_hasLast || !(state.X_WH.translation == m_place.translation))
	{
		m_place = state.X_WH;
		m_placeSince = now;
	}
	return m_settings.longestTurnInPlace > 0 && now - m_placeSince >= m_settings.turnInPlaceAfter &&
		turnBetween(state.X_WH.rotation, m_place.rotation) > m_settings.longestTurnInPlace;
}

/// `seconds` is the time since the last new sample, because a device may be slower than its reader.
bool SampleMonitor::jumped(const DeviceState& state, double seconds) const noexcept
{
	const double way = distance(state.X_WH.translation, m_last.X_WH.translation);
	const double turn = turnBetween(state.X_WH.rotation, m_last.X_WH.rotation);
	return way > m_settings.longestJump + m_settings.speed * seconds || turn > m_settings.longestTurn + m_settings.angularSpeed * seconds;
}

FaultCause SampleMonitor::judge(const DeviceState& state, std::int64_t now) noexcept
{
	if (!isRigid(state.X_WH) || !isFinite(state.twist)) return FaultCause::InvalidState;
	const bool first = !m_hasLast, repeated = !first && repeats(state);
	const double seconds = 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now - m_lastFresh));
	const bool inPlace = turnsInPlace(state, now);
	// A driver may answer with a sample that it has never read.
	if (first) m_lastFresh = std::min(now, state.sampledAt);
	else if (!repeated) m_lastFresh = now;
	if (!first && jumped(state, seconds)) m_distrust = m_settings.steadySamples;
	else if (m_distrust > 0 && !repeated) --m_distrust;
	m_last = state;
	m_hasLast = true;
	if (m_distrust > 0) return FaultCause::Jump;
	if (inPlace) return FaultCause::PositionFrozen;
	return now - m_lastFresh >= m_settings.frozenAfter ? FaultCause::Frozen : FaultCause::None;
}
}  // namespace devicebridge
