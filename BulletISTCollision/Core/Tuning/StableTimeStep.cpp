// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Tuning/StableTimeStep.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace ist
{
namespace
{
template <class Scalar> double roundingAt(double distance)
{
	const Scalar x = Scalar(std::fabs(distance));
	return 0.5 * (double(std::nextafter(x, std::numeric_limits<Scalar>::infinity())) - double(x));
}
}  // namespace

double contactFrequency(const ContactSpring& spring) { return std::sqrt(spring.stiffness / spring.mass); }

double longestExplicitStep(const ContactSpring& spring)
{
	const double K = spring.stiffness, c = spring.damping;
	// The root of K h^2 + 2 c h - 4 m, in a form without the difference of two large numbers.
	return 4 * spring.mass / (c + std::sqrt(c * c + 4 * K * spring.mass));
}

double implicitRestitution(const ContactSpring& spring, double h)
{
	return std::exp(-0.5 * std::numbers::pi * h * contactFrequency(spring));
}

double longestStepForRestitution(const ContactSpring& spring, double error)
{
	return -2 / std::numbers::pi * std::log1p(-error) / contactFrequency(spring);
}

double thicknessOf(const InnerSphereTree& tree)
{
	return tree.area > 0 ? 2 * tree.volume / tree.area : std::numeric_limits<double>::infinity();
}

double longestStepForThickness(double speed, double thickness) { return kMostTravel * thickness / speed; }

double placeRounding(double distance, bool inDouble) { return inDouble ? roundingAt<double>(distance) : roundingAt<float>(distance); }
}  // namespace ist
