// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Query/VerletListState.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
/// Number of queries that a margin should last. A longer life saves little, and the list grows.
constexpr double kWantedSteps = 10;
/// Smallest number of queries that a list must last to save time.
constexpr double kLeastSteps = 3;
/// Weight of the last query in the estimate of the motion.
constexpr double kLearning = 0.3;
/// Largest share of the margin that lies between the current pose and the pose around which the list is filled.
constexpr double kAhead = 0.8;
/// Limits of the ratio of remembered pairs to intersecting pairs. Above `tooMany` the margin shrinks, and below `few` it may grow. Most
/// pairs that do not intersect cost only a distance test; with packed spheres each one is evaluated in full.
struct Ratios
{
	double tooMany, few;
};
constexpr Ratios kWithShapes{1.9, 1.6}, kOfSpheres{1.6, 1.35};
/// Ratios of intersecting pairs to the capacity. Above kFull the list is not filled again until the ratio falls below kRoomAgain.
constexpr double kFull = 0.8, kRoomAgain = 0.6;
/// Relative change of a grouping above which the pairs are grouped anew.
constexpr double kOldGrouping = 0.1;
}  // namespace

double SeenPose::motionTo(const Pose& other) const
{
	double squared = 0, skew = 0;
	for (const Pose* pose : {&X, &other})
	{
		const Mat3 e = pose->rotation * transpose(pose->rotation);
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j) skew += std::fabs(e.m[i][j] - (i == j ? 1 : 0));
	}
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			const double d = X.rotation.m[i][j] - other.rotation.m[i][j];
			squared += d * d;
		}
	// A difference of rotations has two equal singular values, and the third is zero. `skew` covers the deviation of both matrices from
	// rotations.
	return distance(X * center, other * center) + (std::sqrt(0.5 * squared) + skew) * reach;
}

Pose SeenPose::moved(const Vec3& drift, const Vec3& turn) const
{
	const Mat3 R = rotationMatrix(quaternionFromRotationVector(turn)) * X.rotation;
	return {R, X * center + drift - R * center};
}

VerletList::Implementation::Implementation(int pairs)
{
	a.resize(size_t(std::max(0, pairs)));
	for (auto* like : {&b, &m_sortedA, &m_sortedB}) like->resize(a.size());
	m_patchOf.resize(a.size());
}

void VerletList::Implementation::forget()
{
	valid = false;
	m_A = m_B = nullptr;
}

bool VerletList::Implementation::covers(const BallTree& A, const BallTree& B, const QueryOptions& options, const SeenPose& now)
{
	const bool same = m_A == &A && m_B == &B && m_ballsA == A.slotCount() && m_ballsB == B.slotCount() && m_model == options.model &&
		m_bounds == options.listMeetingBounds;
	if (!same)
	{
		m_A = &A;
		m_B = &B;
		m_ballsA = A.slotCount();
		m_ballsB = B.slotCount();
		m_model = options.model;
		m_bounds = options.listMeetingBounds;
		valid = m_full = false;
		// This is less than half of the distance between the centres of neighbouring balls.
		m_most = 0.35 * now.reach / std::cbrt(double(std::max<size_t>(1, m_ballsB)));
		m_step = -1;
	}
	else learnMotion(now);
	m_last = now;
	return valid = valid && m_filled.motionTo(now.X) <= m_margin;
}

void VerletList::Implementation::learnMotion(const SeenPose& now)
{
	const double motion = m_last.motionTo(now.X);
	const Vec3 drift = now.X * now.center - m_last.X * m_last.center,
			   turn = rotationVector(quaternion(now.X.rotation * transpose(m_last.X.rotation)));
	const bool first = m_step < 0;
	const double swerve = first ? motion : SeenPose{m_last.moved(m_drift, m_turn), now.center, now.reach}.motionTo(now.X);
	const auto learn = [first](auto& of, const auto& seen) { of = first ? seen : of + kLearning * (seen - of); };
	learn(m_step, motion);
	learn(m_swerve, swerve);
	learn(m_drift, drift);
	learn(m_turn, turn);
}

double VerletList::Implementation::marginToFill() const
{
	if (m_full || m_step < 0 || !(pace() * kLeastSteps <= m_most)) return 0;
	return std::clamp(kWantedSteps * pace(), 0.25 * m_most, m_most);
}

Pose VerletList::Implementation::poseToFill(double margin) const
{
	const double way = SeenPose{m_last.moved(m_drift, m_turn), m_last.center, m_last.reach}.motionTo(m_last.X);
	if (!(way > 0)) return m_last.X;
	const double queries = std::min(kAhead * margin / way, 0.5 * kWantedSteps);
	const Pose ahead = m_last.moved(queries * m_drift, queries * m_turn);
	return m_last.motionTo(ahead) <= margin ? ahead : m_last.X;
}

void VerletList::Implementation::begin(double margin, const Pose& X)
{
	count = 0;
	m_patches = 0;
	valid = margin > 0;
	m_margin = margin;
	m_filled = m_last;
	m_filled.X = X;
}

void VerletList::Implementation::append(const uint32_t* pairA, const uint32_t* pairB, int number)
{
	valid = valid && count + size_t(number) <= a.size();
	if (!valid) return;
	std::copy_n(pairA, number, a.begin() + ptrdiff_t(count));
	std::copy_n(pairB, number, b.begin() + ptrdiff_t(count));
	count += size_t(number);
}

void VerletList::Implementation::end(int64_t found)
{
	m_full = double(found) > (m_full ? kRoomAgain : kFull) * double(a.size());
	if (m_full || m_margin <= 0) return;
	const Ratios limits = m_model == Model::Inner ? kOfSpheres : kWithShapes;
	const double ratio = double(count) / double(std::max<int64_t>(1, found));
	if (!valid || ratio > limits.tooMany) m_most *= 0.8;
	else if (ratio < limits.few) m_most *= 1.1;
}

void VerletList::Implementation::divide(int patches)
{
	size_t next[kMostPatches + 1] = {};
	for (size_t i = 0; i < count; ++i) ++next[m_patchOf[i] + 1];
	for (int p = 0; p < patches; ++p) m_first[p + 1] = next[p + 1] += next[p];
	for (size_t i = 0; i < count; ++i)
	{
		const size_t to = next[m_patchOf[i]]++;
		m_sortedA[to] = a[i];
		m_sortedB[to] = b[i];
	}
	a.swap(m_sortedA);
	b.swap(m_sortedB);
	m_patches = patches;
}

VerletList::Implementation::Grouping::Grouping(const OverlapIntegrals* patches, int number)
{
	for (int p = 0; p < number; ++p)
	{
		pairs += patches[p].pairs;
		volume += patches[p].volume;
		aligned += norm(patches[p].normalA.force);
	}
}

bool VerletList::Implementation::isGrouping(const OverlapIntegrals* patches, int number) const
{
	const Grouping now(patches, number);
	const bool asMany = std::fabs(double(now.pairs - m_grouped.pairs)) <= kOldGrouping * double(m_grouped.pairs);
	return asMany && now.aligned * m_grouped.volume >= (1 - kOldGrouping) * m_grouped.aligned * now.volume;
}

VerletList::VerletList(int pairs) : m_impl(std::make_unique<Implementation>(pairs)) {}
VerletList::~VerletList() = default;
VerletList::VerletList(VerletList&&) noexcept = default;
VerletList& VerletList::operator=(VerletList&&) noexcept = default;
void VerletList::forget() { m_impl->forget(); }
}  // namespace ist
