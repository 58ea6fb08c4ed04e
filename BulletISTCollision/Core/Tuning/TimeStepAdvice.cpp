// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/TimeStepAdvice.h"

#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ist
{
namespace
{
constexpr double kGravity = 9.81, kUnbounded = std::numeric_limits<double>::infinity();

/// Median area of the contacts whose volume is nearest to `volume` on a logarithmic scale.
double areaAt(std::vector<TuneContact> contacts, double volume)
{
	constexpr size_t kNearest = 10;
	const auto off = [&](const TuneContact& c) { return std::fabs(std::log(c.volume / volume)); };
	std::erase_if(contacts, [](const TuneContact& c) { return !(c.volume > 0 && c.area > 0); });
	if (contacts.empty()) return 0;
	std::sort(contacts.begin(), contacts.end(), [&](const TuneContact& a, const TuneContact& b) { return off(a) < off(b); });
	contacts.resize(std::min(contacts.size(), kNearest));
	std::sort(contacts.begin(), contacts.end(), [](const TuneContact& a, const TuneContact& b) { return a.area < b.area; });
	return contacts[contacts.size() / 2].area;
}
}  // namespace

std::optional<Error> problemOf(const WorldSetup& setup)
{
	if (setup.stiffness && setup.mass) return std::nullopt;
	return Error{"a step can be chosen only with both a stiffness and a mass"};
}

Result<TimeStepAdvice> timeStepAdvice(
	const WorldSetup& setup, const InnerSphereTree& A, const InnerSphereTree& B, const std::vector<TuneContact>& contacts, double error)
{
	if (const std::optional<Error> problem = problemOf(setup)) return *problem;
	const double k = *setup.stiffness, m = *setup.mass, volume = m * kGravity / k, area = areaAt(contacts, volume);
	if (!(area > 0)) return Error{"no pose has a contact with an area"};
	const ContactSpring spring{k * area, m, 0};
	TimeStepAdvice needs;
	needs.restDepth = volume / area;
	needs.frequency = contactFrequency(spring);
	needs.explicitStep = longestExplicitStep(spring);
	needs.restitutionStep = setup.speed > 0 && error < 1 ? longestStepForRestitution(spring, error) : kUnbounded;
	needs.thicknessStep = longestStepForThickness(setup.speed, std::min(thicknessOf(A), thicknessOf(B)));
	needs.stepNeeded = std::min({needs.restitutionStep, needs.thicknessStep, setup.step});
	needs.substeps = int(std::min(std::ceil(setup.step / needs.stepNeeded * (1 - 1e-12)), 1e9));
	needs.stepNeeded = setup.step / needs.substeps;
	needs.explicitWill = needs.stepNeeded < needs.explicitStep;
	// The factor 2 is there because both bodies are rounded.
	needs.inDouble = 2 * placeRounding(setup.distance, false) > error * needs.restDepth;
	return needs;
}
}  // namespace ist
