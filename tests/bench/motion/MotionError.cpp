// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionError.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

using namespace ist;

namespace bench
{
namespace
{
/// Difference of two states of a body over its size: displacement, and half of the rotation vector.
struct Difference
{
	Vec3 shift, turn;

	Difference operator-(const Difference& o) const { return {shift - o.shift, turn - o.turn}; }
	Difference operator*(double s) const { return {shift * s, turn * s}; }
	double size() const { return norm(shift) + norm(turn); }
};

/// Rotation vector from b to a, World.
Vec3 rotationBetween(const Quaternion& a, const Quaternion& b) { return rotationVector(a * conjugate(b)); }

Difference poseDifference(const MotionState& a, const MotionState& b, double size)
{
	return {(a.position - b.position) / size, 0.5 * rotationBetween(a.rotation, b.rotation)};
}

Difference velocityDifference(const MotionState& a, const MotionState& b, double size)
{
	return {(a.velocity - b.velocity) / size, 0.5 * (a.angular - b.angular)};
}

double finite(double error) { return std::isfinite(error) ? error : std::numeric_limits<double>::infinity(); }
}  // namespace

double poseError(const MotionState& a, const MotionState& b, double size) { return finite(poseDifference(a, b, size).size()); }

std::vector<double> motionErrors(const MotionRun& run, const MotionRun& reference)
{
	std::vector<double> errors;
	for (size_t i = 0; i < std::min(run.checkpoints.size(), reference.checkpoints.size()); ++i)
	{
		double worst = 0;
		for (size_t b = 0; b < run.sizes.size(); ++b)
			worst = std::max(worst, poseError(run.checkpoints[i].bodies[b], reference.checkpoints[i].bodies[b], run.sizes[b]));
		errors.push_back(worst);
	}
	return errors;
}

std::vector<double> closedFormErrors(const MotionRun& run, const MotionScene& scene)
{
	std::vector<double> errors;
	for (const MotionCheckpoint& at : run.checkpoints)
	{
		double worst = 0;
		for (size_t b = 0; b < run.sizes.size(); ++b)
		{
			const std::optional<Pose> X = scene.closedForm(b, at.time);
			if (!X) return {};
			worst = std::max(worst, poseError(at.bodies[b], {X->translation, quaternion(X->rotation), {}, {}}, run.sizes[b]));
		}
		errors.push_back(worst);
	}
	return errors;
}

double largest(const std::vector<double>& errors, size_t count)
{
	return *std::max_element(errors.begin(), errors.begin() + std::ptrdiff_t(std::min(count, errors.size())));
}

MotionRun extrapolated(const MotionRun& run, const MotionRun& atTwiceTheStep)
{
	MotionRun limit = run;
	for (size_t i = 0; i < std::min(run.checkpoints.size(), atTwiceTheStep.checkpoints.size()); ++i)
		for (size_t b = 0; b < run.sizes.size(); ++b)
		{
			const MotionState& twice = atTwiceTheStep.checkpoints[i].bodies[b];
			MotionState& state = limit.checkpoints[i].bodies[b];
			const Mat3 turn = rotationMatrix(quaternionFromRotationVector(rotationBetween(state.rotation, twice.rotation)));
			state.rotation = quaternion(turn * rotationMatrix(state.rotation));
			state.position = 2 * state.position - twice.position;
			state.velocity = 2 * state.velocity - twice.velocity;
			state.angular = 2 * state.angular - twice.angular;
		}
	return limit;
}

MotionGrowth growthOf(const MotionRun& run, const MotionRun& perturbed, double perturbation)
{
	constexpr double kMost = 100;
	const std::vector<double> errors = motionErrors(perturbed, run);
	MotionGrowth growth;
	growth.factor = largest(errors, errors.size()) / perturbation;
	while (growth.checkpoints < errors.size() && errors[growth.checkpoints] < kMost * perturbation) ++growth.checkpoints;
	if (growth.checkpoints > 0) growth.judged = std::max(1.0, largest(errors, growth.checkpoints) / perturbation);
	return growth;
}

std::vector<double> addedErrors(const MotionRun& run, const MotionRun& reference, size_t count, ErrorCharge charge)
{
	std::vector<double> added;
	for (size_t i = 1; i < count; ++i)
	{
		const MotionCheckpoint &now = run.checkpoints[i], &before = run.checkpoints[i - 1];
		const MotionCheckpoint &trueNow = reference.checkpoints[i], &trueBefore = reference.checkpoints[i - 1];
		const double took = now.time - before.time, left = reference.checkpoints[count - 1].time - now.time;
		double worst = 0;
		for (size_t b = 0; b < run.sizes.size(); ++b)
		{
			const double size = run.sizes[b];
			const Difference pose = poseDifference(now.bodies[b], trueNow.bodies[b], size) -
				poseDifference(before.bodies[b], trueBefore.bodies[b], size);
			const Difference velocityBefore = velocityDifference(before.bodies[b], trueBefore.bodies[b], size);
			const Difference velocity = velocityDifference(now.bodies[b], trueNow.bodies[b], size) - velocityBefore;
			worst = std::max(
				worst, finite(charge == ErrorCharge::Pose ? pose.size() : (pose - velocityBefore * took).size() + velocity.size() * left));
		}
		added.push_back(worst);
	}
	return added;
}

std::optional<MotionHindsight> bestInHindsight(const std::vector<MotionChoice>& choices, double tolerance)
{
	const auto sum = [](const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); };
	std::optional<MotionHindsight> found;
	for (size_t i = 0; i < choices.size(); ++i)
	{
		const double cost = sum(choices[i].costs);
		if (sum(choices[i].errors) <= tolerance && (!found || cost < found->fixedCost)) found = MotionHindsight{cost, cost, i};
	}
	if (!found) return std::nullopt;
	// Each interval takes the choice with the least cost + price * error. The price rises until the errors are within the tolerance.
	constexpr int kPrices = 600;
	for (int k = 0; k < kPrices; ++k)
	{
		const double price = found->fixedCost * std::pow(10.0, -4 + 14.0 * k / kPrices);
		double cost = 0, error = 0;
		for (size_t i = 0; i < choices[0].costs.size(); ++i)
		{
			const MotionChoice* best = nullptr;
			double least = std::numeric_limits<double>::infinity();
			for (const MotionChoice& c : choices)
				if (const double priced = c.costs[i] + price * c.errors[i]; priced < least) least = priced, best = &c;
			if (!best) return found;  // no run is finite there
			cost += best->costs[i];
			error += best->errors[i];
		}
		if (error <= tolerance) found->bestCost = std::min(found->bestCost, cost);
	}
	return found;
}

MotionControl controlled(const std::vector<MotionChoice>& choices, double tolerance)
{
	constexpr double kSafety = 0.8, kMostCoarser = 5;  // usual values of controls of the step
	const size_t intervals = choices.front().costs.size();
	MotionControl control;
	double errorTimesRate = 0, lastRate = 0;
	for (size_t i = 0; i < intervals; ++i)
	{
		const double allowed = tolerance * double(i + 1) / double(intervals) - control.error;
		size_t c = 0;
		while (
			c + 1 < choices.size() && (errorTimesRate > kSafety * allowed * choices[c].rate || choices[c].rate * kMostCoarser < lastRate))
			++c;
		while (true)
		{
			control.cost += choices[c].costs[i];
			if (choices[c].errors[i] <= allowed || c + 1 == choices.size()) break;
			const double rate = choices[c].rate * choices[c].errors[i] / (kSafety * std::max(allowed, 1e-300));
			for (++c; c + 1 < choices.size() && choices[c].rate < rate;) ++c;
		}
		control.error += choices[c].errors[i];
		lastRate = choices[c].rate;
		errorTimesRate = choices[c].errors[i] * lastRate;
	}
	return control;
}
}  // namespace bench
