// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/TuneSettings.h"

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Accuracy/OverlapPoses.h"
#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace ist
{
namespace
{
constexpr int kPosesPerOverlap = 10, kPasses = 3;
constexpr double kHeld = 0.95;

template <class Value> Value quantile(std::vector<Value> values, double share)
{
	const auto at = values.begin() + ptrdiff_t(share * double(values.size() - 1) + 0.5);
	std::nth_element(values.begin(), at, values.end());
	return *at;
}

/// The error that 95 % of the poses do not exceed. Each error bound is twice the standard deviation of a normally distributed error.
double jointError(const std::vector<double>& errorBounds)
{
	const auto held = [&](double error) {
		double sum = 0;
		for (double errorBound : errorBounds) sum += errorBound > 0 ? std::erf(std::sqrt(2.0) * error / errorBound) : 1;
		return sum / double(errorBounds.size());
	};
	double low = 0, high = *std::max_element(errorBounds.begin(), errorBounds.end());
	for (int i = 0; i < 60; ++i)
	{
		const double middle = 0.5 * (low + high);
		(held(middle) < kHeld ? low : high) = middle;
	}
	return high;
}

class Measurement
{
public:
	Measurement(const InnerSphereTree& A, const InnerSphereTree& B, const Progress& progress)
		: m_A(A),
		  m_B(B),
		  m_progress(progress),
		  m_rounds(kPasses * (levelCount(A, B) + 2))
	{
		std::mt19937_64 random(1);
		for (const double overlap : kOverlapsOfContact)
			for (int i = 0; i < kPosesPerOverlap; ++i)
				if (const std::optional<Pose> X = poseAtOverlap(A, B, overlap, 0, random, m_workspace)) m_poses.push_back(*X);
		std::shuffle(m_poses.begin(), m_poses.end(), random);
	}

	Result<TuneSettings> all(double acceptedError)
	{
		if (m_poses.empty()) return Error{"the bodies cannot overlap by 0.1 % of the smaller one when their centres of mass meet"};
		TuneSettings found;
		for (int level = 0; level <= levelCount(m_A, m_B) + 1; ++level)
		{
			const bool byPose = level > levelCount(m_A, m_B);
			ForceTolerance accepted;
			// With a tolerance of 1e300 the first level that is tried answers, whatever its error bound.
			accepted.error = byPose ? acceptedError : 1e300;
			accepted.firstLevel = byPose ? -1 : level;
			Result<TuneSetting> setting = measured(byPose ? -1 : level, accepted, level == 0 ? &found.contacts : nullptr);
			if (!setting) return setting.error();
			found.settings.push_back(setting.value());
		}
		return found;
	}

private:
	/// Measures all poses, several times. `contacts` may be null.
	Result<TuneSetting> measured(int level, const ForceTolerance& accepted, std::vector<TuneContact>* contacts)
	{
		TuneSetting setting;
		setting.spheres = std::max(m_A.spheres.size(), m_B.spheres.size());
		setting.level = level;
		std::vector<double> times(m_poses.size(), 1e300), errors(m_poses.size());
		std::vector<int> patches(m_poses.size());
		for (int pass = 0; pass < kPasses; ++pass, ++m_round)
			for (size_t i = 0; i < m_poses.size(); ++i)
			{
				const double done = (m_round + double(i) / double(m_poses.size())) / m_rounds;
				if (m_progress && !m_progress("tune", done)) return Error{"the tuning was cancelled", true};
				const auto start = std::chrono::steady_clock::now();
				const BoundedOverlap answer = queryWithTolerance(m_A, m_B, m_poses[i], m_workspace, accepted);
				times[i] = std::min(times[i], std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
				if (answer.overlap.status != QueryStatus::Ok)
					return Error{std::string("a query was refused: ") + toString(answer.overlap.status)};
				errors[i] = answer.errorBound;
				patches[i] = answer.overlap.patchCount;
				const OverlapIntegrals& total = answer.overlap.total;
				setting.pairs += double(total.pairs) / double(kPasses * m_poses.size());
				if (contacts && pass == 0) contacts->push_back({total.volume, norm(total.areaVector)});
			}
		setting.error = jointError(errors);
		setting.microseconds = quantile(times, 0.5);
		setting.patches = quantile(patches, kHeld);
		return setting;
	}

	const InnerSphereTree& m_A;
	const InnerSphereTree& m_B;
	const Progress& m_progress;
	int m_round = 0, m_rounds;  ///< passes over the poses: completed ones, and the total for all levels
	QueryWorkspace m_workspace;
	std::vector<Pose> m_poses;
};
}  // namespace

Result<TuneSettings> measureSettings(const InnerSphereTree& A, const InnerSphereTree& B, double acceptedError, const Progress& progress)
{
	if (const Result<InstructionSet> chosen = chosenInstructionSet(); !chosen) return chosen.error();
	return Measurement(A, B, progress).all(acceptedError);
}
}  // namespace ist
