// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/AccuracySweep.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

using namespace ist;

namespace scenes
{
namespace
{
double percentile(std::vector<double> values, double share)
{
	if (values.empty()) return 0;
	const auto at = values.begin() + long(share * double(values.size() - 1));
	std::nth_element(values.begin(), at, values.end());
	return *at;
}
}  // namespace

std::vector<JudgedPose> judgePoses(const OverlapQuadrature& truth, const std::vector<Pose>& poses, int linesPerAxis, int pointsTotal)
{
	std::vector<JudgedPose> judged(poses.size());
	std::atomic<size_t> next{0};
	const auto work = [&] {
		for (size_t i = next++; i < poses.size(); i = next++)
		{
			const QuadratureTruth t = truth.integrate(poses[i], {}, linesPerAxis, pointsTotal, i + 1);
			judged[i] = {poses[i], t.wrench().force, t.normalError};
		}
	};
	std::vector<std::thread> threads;
	for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) threads.emplace_back(work);
	work();
	for (std::thread& thread : threads) thread.join();
	return judged;
}

double forceError(const Vec3& force, const JudgedPose& truth, double floor)
{
	return norm(force - truth.force) / std::max(norm(truth.force), floor);
}

std::vector<AccuracyPoint> sweepAccuracy(
	const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<JudgedPose>& poses, const std::vector<double>& accepted)
{
	using Clock = std::chrono::steady_clock;
	QueryWorkspace workspace;
	const double floor = forceFloor(A, B);
	std::vector<AccuracyPoint> points;
	for (const double share : accepted)
	{
		std::vector<double> pairs, balls, times, errorBounds, errors;
		AccuracyPoint point;
		point.accepted = share;
		ForceTolerance along;
		along.error = share;
		for (const JudgedPose& pose : poses)
		{
			const auto start = Clock::now();
			const BoundedOverlap answer = queryWithTolerance(A, B, pose.X_AB, workspace, along);
			times.push_back(1e6 * std::chrono::duration<double>(Clock::now() - start).count());
			along.firstLevel = answer.nextLevel;
			pairs.push_back(double(answer.overlap.total.pairs));
			balls.push_back(double(answer.overlap.ballsA->ballCount() + answer.overlap.ballsB->ballCount()));
			errorBounds.push_back(answer.errorBound);
			errors.push_back(forceError(pressureWrench(answer.overlap.total, {}).force, pose, floor));
			point.held += errors.back() <= answer.errorBound;
			point.kept += answer.kept;
		}
		point.pairs = percentile(pairs, 0.5);
		point.balls = percentile(balls, 0.5);
		point.microseconds = percentile(times, 0.5);
		point.errorBound = percentile(errorBounds, 0.95);
		point.medianErrorBound = percentile(errorBounds, 0.5);
		point.error = percentile(errors, 0.95);
		point.middleError = percentile(errors, 0.5);
		point.held /= double(std::max<size_t>(1, poses.size()));
		point.kept /= double(std::max<size_t>(1, poses.size()));
		points.push_back(point);
	}
	return points;
}
}  // namespace scenes
