// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"

#include "BulletISTCollision/Core/Accuracy/ErrorShare.h"
#include "BulletISTCollision/Core/Query/QueryWorkspaceState.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>
#include <cmath>

namespace ist
{
namespace
{
constexpr double kOfBalls = 0.7, kOfFew = 0.25, kOfGaps = 0.2, kMostGaps = 3, kUnmeasured = 0.4;
constexpr double kFloorOverlap = 0.001;
constexpr double kSigmas = 2;  // of the error bar, which the error bound of surfaces is
/// A coarser level is tried next only if its error bound is within this share of the tolerance. So two levels do not alternate.
constexpr double kReserve = 0.8;
/// A coarse level may see too little force. So the bound is also evaluated with the force plus kHope times the error bound. The level
/// that would then suffice is tried, if it is at least kWorthALook levels coarser than the safe choice. With a smaller difference, a
/// traversal that falls short costs more than it may save. Both values were chosen together with the factors above.
constexpr double kHope = 0.7;
constexpr int kWorthALook = 2;

/// Square of one body's part in the relative error. slotCount() stands for the number of balls, because all blocks of a tree but the
/// last few are full.
double squaredPart(const InnerSphereTree& body, const BallTree& tree, int level, double overlap)
{
	const double c = size_t(level) < body.calibration.size() ? body.calibration[size_t(level)] : kUnmeasured;
	const double perBall = body.volume / (double(tree.slotCount()) * overlap), few = kOfFew * perBall;
	return kOfBalls * kOfBalls * c * c * perBall + few * few;
}
}  // namespace

ContactSeen seenIn(const OverlapIntegrals& integrals, double weightA, double weightB)
{
	return {integrals.volume, norm(pressureWrench(integrals, {1, weightA, weightB}).force), norm(integrals.areaVector),
		integrals.forceVariance};
}

double forceFloor(double volumeA, double volumeB) { return kFloorOverlap * std::min(volumeA, volumeB); }

double forceFloor(const InnerSphereTree& A, const InnerSphereTree& B) { return forceFloor(A.volume, B.volume); }

double forceErrorBound(const InnerSphereTree& A, const InnerSphereTree& B, int level, const ContactSeen& seen)
{
	const LevelPair trees = levelOf(A, B, level);
	const double V = std::max(seen.volume, forceFloor(A, B));
	if (level == 0 && !A.surface.empty() && !B.surface.empty())
		return kSigmas * std::hypot(kFaceForceError * std::sqrt(seen.forceVariance), kSurfaceForceError * V);
	const double ofBalls = squaredPart(A, *trees.treeA, trees.a, V) + squaredPart(B, *trees.treeB, trees.b, V);
	const double gaps = std::min((A.errorLength() + B.errorLength()) * seen.area / V, kMostGaps);
	return V * std::hypot(std::sqrt(ofBalls), kOfGaps * gaps);
}

namespace
{
/// Surfaces answer in less time than leaves with more balls per element than this. A level counts only where it saves time: with
/// bodies that are few large faces the leaves of all levels would take longer.
constexpr double kBallsPerElement = 2;

bool savesTime(const InnerSphereTree& A, const InnerSphereTree& B, int level)
{
	if (A.surface.empty() || B.surface.empty()) return true;
	const LevelPair trees = levelOf(A, B, level);
	return double(trees.treeA->slotCount() + trees.treeB->slotCount()) <
		kBallsPerElement * double(A.surface.surface.elements.size() + B.surface.surface.elements.size());
}
}  // namespace

int chooseLevel(const InnerSphereTree& A, const InnerSphereTree& B, const ContactSeen& seen, double error)
{
	for (int level = levelCount(A, B); level > 0 && savesTime(A, B, level); --level)
		if (shareOfTrueForce(forceErrorBound(A, B, level, seen), seen.force, forceFloor(A, B)) <= error) return level;
	return 0;
}

namespace
{
/// The level to query after `level` did not meet the tolerance. Where forces cancel, a coarse level gives little of the remaining
/// force. Its own bound alone would often select the leaves although a level in between suffices.
int nextLook(const InnerSphereTree& A, const InnerSphereTree& B, int level, const ContactSeen& seen, double error)
{
	ContactSeen hoped = seen;
	hoped.force += kHope * forceErrorBound(A, B, level, seen);
	const int sure = std::min(chooseLevel(A, B, seen, error), level - 1), coarsest = std::min(chooseLevel(A, B, hoped, error), level - 1);
	const int next = coarsest - sure < kWorthALook ? sure : coarsest;
	return next > 0 && savesTime(A, B, next) ? next : 0;
}
}  // namespace

BoundedOverlap queryWithTolerance(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const ForceTolerance& accepted, const QueryOptions& options, VerletList* memory)
{
	BoundedOverlap answer;
	const int finest = std::max(0, options.level), coarsest = std::max(finest, levelCount(A, B));
	QueryOptions at = options;
	at.level = accepted.firstLevel < 0 ? coarsest : std::clamp(accepted.firstLevel, finest, coarsest);
	// Memory is reserved at once, so that a finer level does not allocate in a later query.
	workspace.implementation().reserveFor(A.law, B.law);
	for (;;)
	{
		answer.overlap = queryOverlap(A, B, X_AB, workspace, at, memory);
		++answer.traversals;
		answer.pairs += answer.overlap.total.pairs;
		if (answer.overlap.status != QueryStatus::Ok) return answer;
		const ContactSeen seen = seenIn(answer.overlap.total, accepted.weightA, accepted.weightB);
		answer.errorBound = shareOfTrueForce(forceErrorBound(A, B, answer.overlap.level, seen), seen.force, forceFloor(A, B));
		answer.kept = answer.errorBound <= accepted.error;
		if (answer.kept || at.level == finest || answer.overlap.coarsened)
		{
			answer.nextLevel = std::max(at.level, chooseLevel(A, B, seen, kReserve * accepted.error));
			return answer;
		}
		at.level = std::max(finest, nextLook(A, B, at.level, seen, accepted.error));
	}
}
}  // namespace ist
