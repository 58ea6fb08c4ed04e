// SPDX-License-Identifier: Zlib
#include "demos/scenes/Truth/PoseSampler.h"

#include <algorithm>
#include <random>

using namespace ist;

namespace scenes
{
namespace
{
Quaternion randomRotation(std::mt19937_64& random)
{
	std::normal_distribution<double> gauss;
	Quaternion q{gauss(random), gauss(random), gauss(random), gauss(random)};
	const double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
	return {q.x / n, q.y / n, q.z / n, q.w / n};
}

Vec3 randomDirection(std::mt19937_64& random)
{
	std::normal_distribution<double> gauss;
	return normalized({gauss(random), gauss(random), gauss(random)});
}
}  // namespace

Quaternion randomRotation(uint64_t seed)
{
	std::mt19937_64 random(seed);
	return randomRotation(random);
}

std::vector<Pose> posesAtOverlap(const OverlapQuadrature& quadrature, double fraction, int count, uint64_t seed)
{
	constexpr int kLines = 40, kHalvings = 40, kTriesPerPose = 5;
	constexpr double kTolerance = 0.05;
	const auto& a = quadrature.extentA();
	const auto& b = quadrature.extentB();
	const double target = fraction * std::min(a.volume, b.volume);
	std::mt19937_64 random(seed);
	std::vector<Pose> poses;
	for (int tries = 0; static_cast<int>(poses.size()) < count && tries < kTriesPerPose * count; ++tries)
	{
		const Mat3 rotation = rotationMatrix(randomRotation(random));
		const Vec3 direction = randomDirection(random);
		const auto poseAt = [&](double s) { return Pose{rotation, a.center + s * direction - rotation * b.center}; };
		double inner = 0, outer = a.radius + b.radius;
		for (int i = 0; i < kHalvings; ++i)
		{
			const double s = 0.5 * (inner + outer);
			const double volume = quadrature.integrate(poseAt(s), {}, kLines, 0, seed + 1).volume;
			if (std::fabs(volume - target) <= kTolerance * target)
			{
				poses.push_back(poseAt(s));
				break;
			}
			(volume > target ? inner : outer) = s;
		}
	}
	return poses;
}
}  // namespace scenes
