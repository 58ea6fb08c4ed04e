// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionSweep.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace bench
{
namespace
{
using Contact = MotionSettings::Contact;

constexpr std::array kLevelRates = {60, 240, 960};
constexpr std::array kStockRates = {60, 120, 240, 480, 960, 1920};

MotionSettings at(Contact contact, int rate, double forceError = 0, double perturbation = 0)
{
	return {contact, rate, forceError, perturbation, false, 0};
}

/// Whether nothing but the step is varied: materials given, the finest queries, the scene's own spheres.
bool variesTheStepAlone(const MotionSettings& s)
{
	return s.contact == Contact::Given && !(s.forceError > 0) && !s.isFlightExact && s.spheres == 0;
}

/// The runs that tell what is true.
std::vector<MotionSettings> references(const MotionEntry& entry)
{
	std::vector<MotionSettings> all;
	for (const Contact contact : {Contact::Given, Contact::Default})
	{
		for (const int part : {1, 2, 4}) all.push_back(at(contact, entry.referenceRate / part));
		all.push_back(at(contact, entry.referenceRate / 4, 0, kPerturbation));
	}
	return all;
}

/// The runs that are judged. Coarser levels come last, because they change the trees.
std::vector<MotionSettings> judged(const MotionEntry& entry)
{
	std::vector<MotionSettings> all;
	for (const Contact contact : {Contact::Given, Contact::Default})
		for (const int rate : ratesOf(entry)) all.push_back(at(contact, rate));
	// Bullet's own contact of meshes takes long.
	for (const int rate : kStockRates)
		if (!entry.meetsTrees || rate <= 480) all.push_back(at(Contact::Stock, rate));
	if (entry.fliesFreely)
		for (const int rate : kLevelRates) all.push_back({Contact::Given, rate, 0, 0, true, 0});
	if (entry.meetsTrees)
		for (const int spheres : kFewSpheres) all.push_back({Contact::Given, kSphereRate, 0, 0, false, spheres});
	if (entry.meetsTrees)
		for (const double error : kForceErrors)
			for (const int rate : kLevelRates) all.push_back(at(Contact::Given, rate, error));
	return all;
}

struct Reference
{
	MotionRun run;
	size_t judgedCount = 0;
};

/// Reads the reference of a contact, and judges it.
Result<Reference> judgeReference(const MotionRecords& records, const MotionEntry& entry, Contact contact, MotionTruth& truth)
{
	const auto run = [&](int part, double perturbation) {
		return records.find(entry, at(contact, entry.referenceRate / part, 0, perturbation), true);
	};
	const std::optional<MotionRun> best = run(1, 0), half = run(2, 0), quarter = run(4, 0), perturbed = run(4, kPerturbation);
	if (!best || !half || !quarter || !perturbed)
		return Error{std::string(entry.name) + ": the runs in double precision are missing; start bench_motion_error-float64 first"};
	truth.growth = growthOf(*quarter, *perturbed, kPerturbation);
	const size_t count = std::max<size_t>(truth.growth.checkpoints, 2);
	MotionRun limit = extrapolated(*best, *half);
	truth.convergence = largest(motionErrors(extrapolated(*half, *quarter), limit), count);
	truth.until = best->checkpoints[count - 1].time;
	return Reference{std::move(limit), count};
}

MotionCost perSecond(const MotionRun& run, double seconds)
{
	const MotionCost& c = run.checkpoints.back().cost;
	return {c.steps / seconds, c.queries / seconds, c.pairs / seconds, c.seconds / seconds};
}

using CostOf = double (*)(const MotionCost&);
double count(const MotionCost& cost) { return cost.count(); }
double seconds(const MotionCost& cost) { return cost.seconds; }

std::vector<MotionChoice> choicesOf(
	const std::vector<MotionRun>& runs, const std::vector<int>& rates, const Reference& reference, CostOf cost, ErrorCharge charge)
{
	std::vector<MotionChoice> choices;
	for (size_t r = 0; r < runs.size(); ++r)
	{
		MotionChoice choice;
		choice.rate = rates[r];
		choice.errors = addedErrors(runs[r], reference.run, reference.judgedCount, charge);
		for (size_t i = 1; i < reference.judgedCount; ++i)
			choice.costs.push_back(cost(runs[r].checkpoints[i].cost - runs[r].checkpoints[i - 1].cost));
		choices.push_back(std::move(choice));
	}
	std::sort(choices.begin(), choices.end(), [](const MotionChoice& a, const MotionChoice& b) { return a.rate < b.rate; });
	return choices;
}

double gainOfControl(const std::optional<MotionHindsight>& fixed, const std::vector<MotionChoice>& choices, double tolerance)
{
	const MotionControl control = controlled(choices, tolerance);
	return fixed && control.error <= tolerance ? fixed->fixedCost / control.cost : 0;
}

std::vector<MotionGain> gainsOf(
	const std::vector<MotionRun>& runs, const std::vector<int>& rates, const Reference& reference, const MotionTruth& truth)
{
	std::vector<MotionGain> gains;
	const auto ratio = [](const std::optional<MotionHindsight>& h) { return h && h->bestCost > 0 ? h->fixedCost / h->bestCost : 0; };
	const auto byCountAndPose = choicesOf(runs, rates, reference, count, ErrorCharge::Pose);
	const auto bySecondsAndPose = choicesOf(runs, rates, reference, seconds, ErrorCharge::Pose);
	const auto byCountAndVelocity = choicesOf(runs, rates, reference, count, ErrorCharge::Velocity);
	for (const double tolerance : kTolerances)
	{
		MotionGain gain;
		gain.tolerance = tolerance;
		gain.allowed = tolerance * truth.until * truth.growth.judged;
		gains.push_back(gain);
		if (truth.convergence > 0.5 * gain.allowed || gain.allowed > 1) continue;
		const auto byCount = bestInHindsight(byCountAndPose, gain.allowed);
		gain.byCount = ratio(byCount);
		if (byCount) gain.rate = int(byCountAndPose[byCount->fixed].rate);
		gain.bySeconds = ratio(bestInHindsight(bySecondsAndPose, gain.allowed));
		const auto byVelocity = bestInHindsight(byCountAndVelocity, gain.allowed);
		gain.byVelocity = ratio(byVelocity);
		gain.byControl = gainOfControl(byCount, byCountAndPose, gain.allowed);
		gain.byControlOfVelocity = gainOfControl(byVelocity, byCountAndVelocity, gain.allowed);
		gains.back() = gain;
	}
	return gains;
}
}  // namespace

const MotionRow* MotionFindings::row(Contact contact, int rate, double forceError, bool isFlightExact) const
{
	for (const MotionRow& r : rows)
		if (r.settings.contact == contact && r.settings.rate == rate && r.settings.forceError == forceError &&
			r.settings.isFlightExact == isFlightExact && r.settings.spheres == 0)
			return &r;
	return nullptr;
}

const MotionRow* MotionFindings::rowOfSpheres(int spheres) const
{
	for (const MotionRow& r : rows)
		if (r.settings.spheres == spheres) return &r;
	return nullptr;
}

const MotionRow* MotionFindings::cheapest(Contact contact, double tolerance) const
{
	const MotionRow* best = nullptr;
	for (const MotionRow& r : rows)
		if (r.settings.contact == contact && !r.settings.isFlightExact && r.settings.spheres == 0 && r.error <= tolerance &&
			(!best || r.cost.count() < best->cost.count()))
			best = &r;
	return best;
}

std::vector<int> ratesOf(const MotionEntry& entry)
{
	// In steps between checkpoints. From 60 Hz to 480 Hz, where games step, by a factor of some 1.19; by 2 elsewhere.
	std::vector<int> rates;
	for (const int steps : {1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 13, 16, 32, 64, 128, 256, 333})
		if (const int rate = steps * kCheckpointRate; 6 * rate <= entry.referenceRate) rates.push_back(rate);
	return rates;
}

std::optional<Error> recordRuns(MotionRecords& records, const MotionEntry& entry)
{
	std::vector<MotionSettings> all = judged(entry);
	if (MotionRecords::isDouble())
	{
		const std::vector<MotionSettings> first = references(entry);
		all.insert(all.begin(), first.begin(), first.end());
	}
	for (const MotionSettings& settings : all)
	{
		if (!MotionRecords::isDouble() && !variesTheStepAlone(settings)) continue;
		if (const Result<MotionRun> run = records.run(entry, settings); !run) return run.error();
	}
	return std::nullopt;
}

Result<MotionFindings> judgeRuns(MotionRecords& records, const MotionEntry& entry)
{
	const Result<MotionScene*> scene = records.scene(entry);
	if (!scene) return scene.error();
	MotionFindings found{entry, 0, 0, entry.referenceRate, {}, {}, {}};
	Reference references[2];
	for (const Contact contact : {Contact::Given, Contact::Default})
	{
		MotionTruth& truth = found.truths[int(contact)];
		Result<Reference> reference = judgeReference(records, entry, contact, truth);
		if (!reference) return reference.error();
		references[int(contact)] = std::move(reference).value();
		const std::vector<double> closed = closedFormErrors(references[int(contact)].run, *scene.value());
		if (!closed.empty()) truth.closedError = largest(closed, closed.size());
	}
	found.bodies = references[0].run.sizes.size();
	found.size = references[0].run.sizes[0];

	std::vector<MotionRun> steps;
	std::vector<int> rates;
	for (const MotionSettings& settings : judged(entry))
	{
		std::optional<MotionRun> run = records.find(entry, settings, true);
		if (!run) continue;
		// Bullet's own contact is judged by the motion of rigid bodies, to which materials that are given come close.
		const Reference& reference = references[settings.contact == Contact::Default];
		MotionRow row;
		row.settings = settings;
		row.error = largest(motionErrors(*run, reference.run), reference.judgedCount);
		row.cost = perSecond(*run, entry.seconds);
		if (const std::vector<double> closed = closedFormErrors(*run, *scene.value()); !closed.empty())
			row.closedError = largest(closed, closed.size());
		if (const auto single = records.find(entry, settings, false))
			row.singleError = largest(motionErrors(*single, reference.run), reference.judgedCount);
		if (settings.forceError > 0 || settings.spheres > 0)
			if (const auto finest = records.find(entry, at(settings.contact, settings.rate), true))
				row.queryError = largest(motionErrors(*run, *finest), reference.judgedCount);
		found.rows.push_back(row);
		if (!variesTheStepAlone(settings)) continue;
		steps.push_back(std::move(*run));
		rates.push_back(settings.rate);
	}
	// Where not even 10 kHz are enough, the runs of the reference are choices, too.
	for (const int part : {4, 2, 1})
		if (std::optional<MotionRun> run = records.find(entry, at(Contact::Given, entry.referenceRate / part), true))
			steps.push_back(std::move(*run)), rates.push_back(entry.referenceRate / part);
	found.gains = gainsOf(steps, rates, references[0], found.truths[0]);
	return found;
}

MotionEntry quick(MotionEntry entry)
{
	entry.referenceRate = std::min(entry.referenceRate, 3840);
	return entry;
}
}  // namespace bench
