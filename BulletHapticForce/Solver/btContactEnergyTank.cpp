// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btContactEnergyTank.h"

#include "BulletISTCollision/PairQuery/btISTFirstTouch.h"

#include <algorithm>
#include <cmath>

namespace
{
/// Smallest pressure of a separating contact, as a share of its elastic pressure. In the closed form nothing separates faster than
/// 1/dissipation, but in a finite step a body can.
constexpr double kLeastPressure = 0.5;
/// Share of the energy of the model that bodies placed inside one another may use, where no stiffness was set: enough to come apart.
constexpr double kShareOfBegin = 0.1;
constexpr double kPartingSpeed = 0.3;  // at which such bodies leave each other [m/s]
constexpr double kShallow = 3;         // times the aimed depth, up to which a contact may always return the energy of its depth
constexpr double kCreepTime = 0.1;     // in which what is deeper comes out [s]

double work(const ist::Wrench& impulse, const ist::Twist& twist)
{
	return dot(impulse.force, twist.linear) + dot(impulse.torque, twist.angular);
}

ist::Twist mean(const btEnergyTankPatch& p)
{
	return {0.5 * (p.before.linear + p.after.linear), 0.5 * (p.before.angular + p.after.angular)};
}

/// Twice the energy that the patches hold in linear contact: force times depth. The model's own energy is less robust, because the depths
/// of leaves above the surface are negative.
double capacity(const btISTContact& contact)
{
	double sum = 0;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		const ist::OverlapIntegrals& p = contact.patches[i];
		const double force = norm(
			ist::pressureWrench(p, {contact.constants.k, contact.constants.weightA, contact.constants.weightB}).force);
		const double area = norm(p.areaVector), depth = p.volume / area;
		sum += force * (area > 0 && std::isfinite(depth) ? depth : std::cbrt(std::max(p.volume, 0.0)));
	}
	return sum;
}
/// Energy that lifts the load by the depth of the contact and lets the lighter body leave at kPartingSpeed [J].
double energyToPart(const btISTContact& contact, double depth)
{
	return contact.constants.load * depth + btISTBodyMotion::lighterMassOf(contact) * kPartingSpeed * kPartingSpeed;
}

/// Energy that a contact whose stiffness follows from a load has in any case [J]. Near the depth at which it rests, it is the linear
/// energy of that depth: work that bodies do while they shake by less than that is hardly known, and a contact that holds nothing lets
/// them shake on. A deeper one may lift what presses on it and move the lighter body so fast that it comes out in kCreepTime.
double leastStored(const btISTContact& contact, double most, double h)
{
	const btISTPairConstants& c = contact.constants;
	if (!(c.load > 0)) return 0;
	const double beyond = ist::meanDepth(contact.total) - kShallow * c.depth;
	if (!(beyond > 0)) return 0.5 * most;
	const double speed = beyond / kCreepTime;
	return std::min(
		std::max(norm(contact.pressed), c.load) * speed * h + 0.5 * btISTBodyMotion::lighterMassOf(contact) * speed * speed, 0.5 * most);
}

/// True when the force has reversed since the last step in which it had one direction. Patches that push against each other have no
/// common direction, as on a body that surrounds a thin one.
bool turnsOver(btISTContact& contact)
{
	ist::Vec3 sum;
	double strength = 0;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		const ist::Vec3 force =
			ist::pressureWrench(contact.patches[i], {contact.constants.k, contact.constants.weightA, contact.constants.weightB}).force;
		sum += force;
		strength += norm(force);
	}
	if (!(norm(sum) > 0.5 * strength)) return false;
	const ist::Vec3 direction = contact.X_WA.rotation * (sum / norm(sum)), former = contact.tank.direction;
	contact.tank.direction = direction;
	return dot(direction, former) < -0.5;
}
}  // namespace

bool btContactEnergyTank::begin(btISTContact& contact, double speed, double h)
{
	btISTContactEnergyTank& tank = contact.tank;
	// In a fit, the force also turns when the contact changes sides.
	const bool turned = tank.turned = turnsOver(contact) && contact.wasDeep();
	const double most = capacity(contact);
	if (tank.open)
	{
		// What a long step took beyond what the overlap can hold is damped, too.
		tank.damped = std::min(tank.damped + std::max(tank.stored - most, 0.0), most);
		// A pose ahead is deeper than the present one.
		tank.stored = std::clamp(tank.stored, contact.ahead > 0 ? 0 : leastStored(contact, most, h), most);
		return turned;
	}
	const double depth = ist::meanDepth(contact.total);
	const double flown = 2 * speed * h;  // depth that a body may have reached in one step
	tank.open = true;
	// What does not touch yet has nothing to give.
	tank.stored = depth > flown && !(contact.ahead > 0) ? 0.5 * most * (1 - flown / depth) : 0;
	if (contact.constants.load > 0) tank.stored = std::min(kShareOfBegin * tank.stored, energyToPart(contact, depth));
	return turned;
}

btScaledWork btContactEnergyTank::scaledWork(const btEnergyTankPatch* patches, int count)
{
	btScaledWork sum;
	for (int i = 0; i < count; ++i)
	{
		const double own = work(patches[i].impulse, patches[i].own);
		sum.linear += work(patches[i].impulse, mean(patches[i])) - 0.5 * own;
		sum.square += 0.5 * own;
	}
	return sum;
}

double btContactEnergyTank::share(const btScaledWork& work, double stored)
{
	const auto [linear, square] = work;
	if (!(linear + square > stored)) return 1;
	if (!(square > 0)) return linear > 0 ? std::clamp(stored / linear, 0.0, 1.0) : 1;
	const double root = std::sqrt(linear * linear + 4 * square * stored);
	// This is the larger root of square s^2 + linear s = stored, without cancellation.
	const double share = linear > 0 ? 2 * stored / (root + linear) : (root - linear) / (2 * square);
	return std::clamp(share, 0.0, 1.0);
}

void btContactEnergyTank::hold(btEnergyTankPatch& patch, double share)
{
	patch.after.linear = patch.after.linear - (1 - share) * patch.own.linear;
	patch.after.angular = patch.after.angular - (1 - share) * patch.own.angular;
	patch.impulse = share * patch.impulse;
	patch.elastic = share * patch.elastic;
}

double btContactEnergyTank::enter(btISTContactEnergyTank& tank, const btEnergyTankPatch* patches, int count, double h)
{
	double total = 0, elastic = 0;
	for (int i = 0; i < count; ++i)
	{
		const btEnergyTankPatch& p = patches[i];
		total += work(p.impulse, mean(p));
		elastic += work(p.elastic + h * (p.patch.damping * p.after), mean(p));
	}
	if (!std::isfinite(total)) return 0;
	const double before = tank.stored;
	tank.stored = std::max(tank.stored - std::max(elastic, total), 0.0);
	tank.damped += std::max(before - tank.stored - total, 0.0);
	return total;
}

btISTContactWork btContactEnergyTank::workOf(const btEnergyTankPatch* patches, int count)
{
	btISTContactWork sum;
	sum.acted = true;
	for (int i = 0; i < count; ++i)
	{
		const btEnergyTankPatch& p = patches[i];
		const ist::Twist u = mean(p);
		const ist::Wrench drag = p.patch.damping * u;  // -d(wrench): an approach gives a negative normal part
		const double force = norm(p.patch.wrench.force), normal = dot(p.elastic.force, p.patch.normal);
		double dissipated = 0;
		if (force > 0 && normal > 0)
		{
			// The damping takes no more of the pressure than leaves its least, however fast the bodies part.
			const double taken = dot(drag.force, p.patch.normal) / force;
			const double acted = taken > 1 - kLeastPressure ? (1 - kLeastPressure) / taken : 1;
			dissipated = normal * acted * work(drag, u) / force / (1 - acted * taken);
		}
		sum.damping -= dissipated;
		sum.elastic += work(p.elastic, u) + dissipated;
		sum.friction += work(p.impulse - p.elastic, u);
	}
	return sum;
}
