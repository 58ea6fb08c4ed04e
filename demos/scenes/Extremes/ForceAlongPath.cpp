// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ForceAlongPath.h"

#include "demos/scenes/Extremes/Continuity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kRate = 1000, kCut = 50, kSpeed = 0.25;  // [Hz, Hz, sizes a second]
constexpr int kTicks = 512, kCircle = 128, kStiffnesses = 8, kLooks = 40, kHalvings = 20;
constexpr double kRadius = 0.01, kNudge = 1e-3, kDeepest = 0.1;  // shares of the size

class Path
{
public:
	Path(const PathStart& start, const ForceOfPose& force) : m_start(start), m_force(force), m_normal(normalized(start.trueForce))
	{
		const Vec3 aside = std::fabs(m_normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
		m_tangent = normalized(cross(m_normal, aside));
	}

	/// Force after B was moved by `way`. A motion along the normal presses deeper.
	Vec3 forceAfter(const Vec3& way) const
	{
		Pose X = m_start.X_AB;
		X.translation += way;
		return m_force(X);
	}
	Vec3 alongSlide(int tick) const { return kSpeed * m_start.size * ((tick - 0.5 * kTicks) / kRate) * m_tangent; }

	double noise() const
	{
		std::vector<double> axes[3];
		double mean = 0, power = 0;
		for (int i = 0; i < kTicks; ++i)
		{
			const Vec3 force = forceAfter(alongSlide(i));
			mean += norm(force) / kTicks;
			axes[0].push_back(force.x), axes[1].push_back(force.y), axes[2].push_back(force.z);
		}
		for (const std::vector<double>& axis : axes) power += powerAbove(axis, kRate, kCut);
		return mean > 0 ? std::sqrt(power) / mean : 0;
	}

	double loopWork() const
	{
		double work = 0, least = 0, most = 0;
		for (int i = 0; i < kCircle; ++i)
		{
			const double angle = 2 * std::numbers::pi * i / kCircle, c = std::cos(angle), s = std::sin(angle);
			const Vec3 way = kRadius * m_start.size * (c * m_tangent + s * m_normal);
			const Vec3 step = 2 * std::numbers::pi / kCircle * kRadius * m_start.size * (-s * m_tangent + c * m_normal);
			work += dot(forceAfter(way), step);
			least = std::min(least, work);
			most = std::max(most, work);
		}
		return most > least ? std::fabs(work) / (most - least) : 0;
	}

	double restDepth() const
	{
		const double load = norm(m_start.trueForce), step = 2 * kDeepest / kLooks;
		const auto bears = [&](double depth) { return dot(forceAfter(depth * m_start.size * m_normal), m_normal) >= load; };
		double high = -kDeepest + step;
		// The search starts from above, because a force may decrease again at greater depth.
		while (!bears(high))
			if ((high += step) > kDeepest + 0.5 * step) return std::numeric_limits<double>::quiet_NaN();
		double low = high - step;
		for (int i = 0; i < kHalvings; ++i)
		{
			const double middle = 0.5 * (low + high);
			(bears(middle) ? high : low) = middle;
		}
		return high;
	}

	double stiffness() const
	{
		double most = 0;
		for (int i = 0; i < kStiffnesses; ++i)
		{
			const Vec3 at = alongSlide(i * kTicks / kStiffnesses), nudge = kNudge * m_start.size * m_normal;
			most = std::max(most, dot(forceAfter(at + nudge) - forceAfter(at - nudge), m_normal) / (2 * kNudge * m_start.size));
		}
		return most;
	}

private:
	const PathStart& m_start;
	const ForceOfPose& m_force;
	Vec3 m_normal, m_tangent;
};

Pose inFloat(Pose X)
{
	for (auto& row : X.rotation.m)
		for (double& v : row) v = double(float(v));
	X.translation = {double(float(X.translation.x)), double(float(X.translation.y)), double(float(X.translation.z))};
	return X;
}
}  // namespace

PathQuality followPath(const PathStart& start, const ForceOfPose& force)
{
	const Path path(start, force);
	return {path.noise(), path.loopWork(), path.restDepth(), path.stiffness()};
}

double changeInFloat(const PathStart& start, double distance, const ForceOfPose& force)
{
	// None of these numbers is a short binary fraction, so rounding affects each of them.
	const Pose X_WA{rotationMatrix(quaternionFromRotationVector({0.3, -0.7, 0.2})), distance * normalized({0.6, 0.3, -0.74})};
	const Pose X_WB = X_WA * start.X_AB;
	const Vec3 before = force(inverse(X_WA) * X_WB), after = force(inverse(inFloat(X_WA)) * inFloat(X_WB));
	return norm(after - before) / norm(before);
}
}  // namespace scenes
