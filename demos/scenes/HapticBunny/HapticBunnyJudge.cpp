// SPDX-License-Identifier: Zlib
#include "demos/scenes/HapticBunny/HapticBunnyJudge.h"

#include "BulletISTCollision/Core/Query/OverlapQuery.h"
#include "demos/scenes/Truth/MeshBelowPlane.h"
#include "demos/scenes/Truth/OverlapQuadrature.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace scenes
{
namespace
{
constexpr int kQuadratureLines = 150, kQuadraturePoints = 60000;

/// Height of the plane at which `volumeAt` reaches `volume`, by bisection between `bottom` and `top`.
template <class VolumeAt> double heightOf(double volume, double bottom, double top, const VolumeAt& volumeAt)
{
	double low = bottom, high = top;
	for (int i = 0; i < 60; ++i)
	{
		const double middle = 0.5 * (low + high);
		(volumeAt(middle) < volume ? low : high) = middle;
	}
	return 0.5 * (low + high);
}

double quantile(const std::vector<double>& sorted, double p)
{
	if (sorted.empty()) return 0;
	return sorted[std::min(sorted.size() - 1, static_cast<size_t>(p * static_cast<double>(sorted.size())))];
}

bool isFiniteSample(const TraceSample& s)
{
	return isFinite(s.hand) && isFinite(s.elastic) && isRigid(s.body) && isRigid(s.tool) && std::isfinite(s.volume);
}
}  // namespace

Sinkage judgeSinkage(const InnerSphereTree& tree, const Mesh& mesh, const Pose& X_WB, double volume)
{
	const double bottom = lowestPoint(mesh, X_WB), reach = tree.box.longestSide();
	const Vec3 up = transpose(X_WB.rotation) * Vec3{0, 1, 0};
	QueryWorkspace workspace;
	const auto ofTree = [&](double height) { return queryHalfSpace(tree, up, height - X_WB.translation.y, workspace).total.volume; };
	const auto ofMesh = [&](double height) { return volumeBelow(mesh, X_WB, height); };
	// The tree's search begins below the mesh, because its balls may reach a little lower.
	return {-bottom, heightOf(volume, bottom - 0.05 * reach, bottom + 0.5 * reach, ofTree) - bottom,
		heightOf(volume, bottom, bottom + 0.5 * reach, ofMesh) - bottom, tree.meanGap};
}

void judgeTrace(const Mesh& body, const Mesh& probe, double bodyWeight, const HapticBunnyOptions& options, HapticBunnyOutcome& outcome)
{
	std::vector<size_t> touching;
	for (size_t i = 0; i < outcome.trace.size(); ++i)
		if (outcome.trace[i].volume > 0) touching.push_back(i);
	const size_t count = std::min(touching.size(), static_cast<size_t>(std::max(options.comparisons, 0)));
	if (count == 0) return;
	const OverlapQuadrature quadrature(body, probe);
	std::vector<double> angles;
	double volume = 0, volumeTruth = 0, force = 0, forceTruth = 0;
	for (size_t c = 0; c < count; ++c)
	{
		if (options.progress && !options.progress("quadrature", static_cast<double>(c) / static_cast<double>(count))) break;
		TraceComparison found;
		found.sample = touching[(2 * c + 1) * touching.size() / (2 * count)];
		const TraceSample& sample = outcome.trace[found.sample];
		const QuadratureTruth truth = quadrature.integrate(inverse(sample.body) * sample.tool, {}, kQuadratureLines, kQuadraturePoints);
		found.volumeTruth = truth.volume;
		found.forceTruth = sample.body.rotation * (-outcome.pairStiffness * truth.wrench(bodyWeight, 1 - bodyWeight).force);
		found.volumeError = sample.volume - truth.volume;
		found.forceError = norm(sample.elastic - found.forceTruth);
		volume += found.volumeError * found.volumeError;
		volumeTruth += truth.volume * truth.volume;
		force += found.forceError * found.forceError;
		forceTruth += squaredNorm(found.forceTruth);
		angles.push_back(std::atan2(norm(cross(sample.elastic, found.forceTruth)), dot(sample.elastic, found.forceTruth)));
		outcome.comparisons.push_back(found);
	}
	if (volumeTruth > 0) outcome.volumeRms = std::sqrt(volume / volumeTruth);
	if (forceTruth > 0) outcome.forceRms = std::sqrt(force / forceTruth);
	std::sort(angles.begin(), angles.end());
	outcome.forceDirection = quantile(angles, 0.5);
}

void summarise(HapticBunnyOutcome& outcome)
{
	std::vector<double> queries, periods;
	outcome.finite = !outcome.trace.empty();
	double sum = 0;
	for (size_t i = 0; i < outcome.trace.size(); ++i)
	{
		const TraceSample& s = outcome.trace[i];
		outcome.finite = outcome.finite && isFiniteSample(s);
		outcome.maxForce = std::max(outcome.maxForce, norm(s.hand.force));
		outcome.maxTorque = std::max(outcome.maxTorque, norm(s.hand.torque));
		outcome.maxPairs = std::max(outcome.maxPairs, s.pairs);
		if (s.volume > 0) queries.push_back(s.queryMicroseconds);
		if (i == 0) continue;
		periods.push_back(s.period);
		sum += s.period;
	}
	std::sort(queries.begin(), queries.end());
	std::sort(periods.begin(), periods.end());
	outcome.medianQuery = quantile(queries, 0.5);
	outcome.p99Query = quantile(queries, 0.99);
	outcome.periods = {quantile(periods, 0.5), quantile(periods, 0.99), quantile(periods, 0.999), quantile(periods, 1)};
	if (sum > 0) outcome.meanRate = static_cast<double>(periods.size()) / sum;
	outcome.cameFree = outcome.finite && outcome.trace.back().volume == 0;
	for (const ProbePhase& phase : outcome.phases)
	{
		const auto touchesIn = [&](const TraceSample& s) { return s.time >= phase.begin && s.time < phase.end && s.volume > 0; };
		if (phase.touches && std::none_of(outcome.trace.begin(), outcome.trace.end(), touchesIn))
			outcome.phasesWithoutContact.push_back(phase.name);
	}
}
}  // namespace scenes
