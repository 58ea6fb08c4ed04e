// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btContactLaw.h"

#include "BulletISTCollision/Core/Base/PlaneAxes.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
using Matrix3 = Eigen::Matrix3d;
constexpr double kFrictionRadiusPerRms = 0.93;
// Times the sum of a patch's stiffnesses that it may have once what is negative is taken away.
constexpr double kMostAdded = 2;
constexpr double kPressedTime = 0.02;  // of the running mean of the normal force [s]
// Most growth of k in a step by what presses, in e-folds: kGrowth (h / kTick)^2.5, at most one; kGrowth h / kTick in steps shorter than
// kTick. A hand does not feel 1 % in its tick. No hand feels the longer steps of a game, and a body tips in less than 0.1 s.
constexpr double kGrowth = 0.01, kTick = 1e-3;
constexpr double kDecay = 20;  // of a k that an impact has raised, e-folds a second
constexpr double kSpare = 4;   // k may stay so many times stiffer than needed; a k that falls lets a body creep
// A contact is clamped if k has grown by this factor while the overlap has changed by less than this share, and twice so: the first time,
// the bodies may have moved while k grew. k waits so long for an overlap that is slow [s].
constexpr double kJudgedGrowth = 2, kClampedChange = 0.2, kJudgedTime = 0.1;
constexpr double kDepthOfStep = 2e-3;   // share of the thinner body that the way of a step may take
constexpr double kDepthOfImpact = 0.1;  // share of it that stopping a body may take in all
constexpr double kRolledPerRadius = 2;  // shares of force times height that rolling by one friction radius leaves out of the stiffness
constexpr double kDampedRolling = 0.5;  // share of that which is left out of the damping; all of it would let an egg tumble on at 60 Hz
constexpr double kAreaOfImpact = 0.1;   // area on which it stops, at least, as a share of the smaller surface: it grows as it sinks in
// Square of the phase in a step up to which steps are explicit in what slides. In a hand's tick a tool may have no momentum (a static
// coupling), which is stable below 1 only.
constexpr double kMostExplicit = 1, kMostExplicitInTick = 0.5;
constexpr double kFlatStiffness = 1e-9;  // across the normal, as a share of that along it: a patch is flat within single precision

double traceOfForces(const ist::SymmetricMatrix6& K) { return K(0, 0) + K(1, 1) + K(2, 2); }

double mostGrowth(double h)
{
	const double ticks = h / kTick, longer = std::max(ticks, 1.0);
	return std::min(kGrowth * ticks * longer * std::sqrt(longer), 1.0);
}

/// Area that the pressure acts on [m^2]. Where a body surrounds the other, its area vectors would cancel.
double pressedArea(const btISTContact& contact)
{
	double area = 0;
	for (int i = 0; i < contact.patchCount; ++i) area += norm(contact.patches[i].areaVector);
	return std::max(area, traceOfForces(ist::pressureStiffness(contact.total, {1, contact.constants.weightA, contact.constants.weightB})));
}

double smallerSurface(const btISTContact& contact)
{
	return contact.treeB ? std::min(contact.treeA->area, contact.treeB->area) : contact.treeA->area;
}

/// Mass that rests on the contact [kg]: `mass` of the lighter body, or half of that whose weight has lately pressed.
double restingMass(const btISTContact& contact, double mass)
{
	const double gravity = contact.constants.gravity;
	return gravity > 0 ? std::max(mass, 0.5 * norm(contact.pressed) / gravity) : mass;
}

/// Energy that the contact stores, at least [J].
double storedEnergy(const btISTContact& contact)
{
	const btISTPairConstants& c = contact.constants;
	return 0.5 * norm(ist::pressureWrench(contact.total, {c.k, c.weightA, c.weightB}).force) * ist::meanDepth(contact.total);
}

Eigen::Vector3d toEigen(const ist::Vec3& v) { return {v.x, v.y, v.z}; }

Matrix3 toEigen(const ist::Mat3& a)
{
	Matrix3 r;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) r(i, j) = a.m[i][j];
	return r;
}

Matrix3 crossMatrix(const Eigen::Vector3d& v)
{
	Matrix3 r;
	r << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
	return r;
}

/// Transforms K from A's mesh axes about A's origin to World axes about the point `c`, which is given from that origin.
ist::SymmetricMatrix6 movedToWorld(const ist::SymmetricMatrix6& K, const Matrix3& R, const Eigen::Vector3d& c)
{
	Matrix3 forces, mixed, torques;  // force per translation, force per rotation, torque per rotation
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			forces(i, j) = K(i, j);
			mixed(i, j) = K(i, j + 3);
			torques(i, j) = K(i + 3, j + 3);
		}
	// A rotation about c moves the point at the origin by c x rotation.
	const Matrix3 X = crossMatrix(c);
	const Matrix3 shifted = forces * X + mixed;
	torques += mixed.transpose() * X - X * shifted;
	forces = R * forces * R.transpose();
	mixed = R * shifted * R.transpose();
	torques = R * torques * R.transpose();
	ist::SymmetricMatrix6 moved;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			moved(i, j + 3) = mixed(i, j);
			if (j < i) continue;
			moved(i, j) = forces(i, j);
			moved(i + 3, j + 3) = torques(i, j);
		}
	return moved;
}

/// The two axes across the normal about which a patch is stiffest and softest against rotation.
struct RollingAxes
{
	Eigen::Vector3d normal, axis[2];
	double stiffness[2];  ///< [N m]

	RollingAxes(const Matrix3& K, const ist::Vec3& n) : normal(toEigen(n))
	{
		ist::Vec3 t1, t2;
		ist::completeFrame(n, t1, t2);
		const Eigen::Vector3d u = toEigen(t1), v = toEigen(t2);
		const ist::PlaneAxes axes(u.dot(K * u), v.dot(K * v), u.dot(K * v));
		axis[0] = std::cos(axes.angle) * u + std::sin(axes.angle) * v;
		axis[1] = -std::sin(axes.angle) * u + std::cos(axes.angle) * v;
		stiffness[0] = axes.larger;
		stiffness[1] = axes.smaller;
	}
	/// Scale of rotations that lowers both stiffnesses by `moment` [N m], to zero at least.
	Matrix3 without(double moment) const
	{
		Matrix3 scale = normal * normal.transpose();
		for (int i = 0; i < 2; ++i)
			if (stiffness[i] > moment) scale += std::sqrt(1 - moment / stiffness[i]) * axis[i] * axis[i].transpose();
		return scale;
	}
};

/// Scales the rotations of a stiffness or damping. A positive semidefinite one stays so.
void scaleRotations(ist::SymmetricMatrix6& matrix, const Matrix3& scale)
{
	Matrix3 mixed, torques;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			mixed(i, j) = matrix(i, 3 + j);
			torques(i, j) = matrix(3 + std::min(i, j), 3 + std::max(i, j));
		}
	mixed = mixed * scale;
	torques = scale * torques * scale;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j)
		{
			matrix(i, 3 + j) = mixed(i, j);
			if (j >= i) matrix(3 + i, 3 + j) = torques(i, j);
		}
}

/// Covariance of the overlap, Int r r^T dV / V about its centroid, in A's mesh axes [m^2].
Matrix3 covariance(const ist::OverlapIntegrals& sums, const Eigen::Vector3d& c)
{
	const double* s = sums.secondMoment;
	Matrix3 second;
	second << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
	return second / sums.volume - c * c.transpose();
}

/// Stiffness that stops an approach: in this step, and altogether [Pa/m].
double stiffnessOfStop(const btISTContact& contact, const btContactLoad& load, double area, double h)
{
	const double thickness = contact.thickness(), inStep = std::max(kSpare * contact.constants.depth, kDepthOfStep * thickness),
				 inAll = kDepthOfImpact * thickness, v = load.approach();
	const double stops = load.mass * v * v / (std::max(area, kAreaOfImpact * smallerSurface(contact)) * inAll * inAll);
	// What the weight adds within a step is no impact: it presses.
	const double impact = v - contact.constants.gravity * h;
	return impact * h > inStep ? std::max(stops, load.mass * v / (h * area * inStep)) : stops;
}

/// Whether a larger k has pushed nothing out. A load that presses is lifted by it; what is held from elsewhere only presses more, and that
/// would be taken for a load in turn.
bool isClamped(btISTContact& contact, double h)
{
	btISTStiffnessGrowth& g = contact.growth;
	const double volume = contact.total.volume;
	if (!(g.k > 0) || std::fabs(volume - g.volume) > kClampedChange * g.volume) g = {contact.grown, volume};
	if (!(contact.grown > kJudgedGrowth * g.k)) return false;
	g.heldFor += h;
	if (g.heldFor < kJudgedTime || g.isSecond) return true;
	g = {contact.grown, volume, 0, true};
	return false;
}

/// A stiffer contact stores more energy at the same depth. Damping must have taken it before, or the growth waits. What damping has taken
/// may also push out a body that has sunk in within a step, before any force acted.
void fillEnergyTank(btISTContact& contact, double former)
{
	btISTContactEnergyTank& tank = contact.tank;
	if (!tank.open) return;
	double& k = contact.constants.k;
	const double stored = storedEnergy(contact), before = former > 0 ? stored * former / k : stored;
	if (stored - before > tank.damped) k = former * (before + tank.damped) / before;
	const double paid = std::min(std::max(stored - tank.stored, 0.0), tank.damped);
	tank.damped -= paid;
	tank.stored += paid;
}
}  // namespace

bool evaluateContactPatch(const btISTContact& contact, int patchIndex, btContactPatch& patch)
{
	const ist::OverlapIntegrals& sums = contact.patches[patchIndex];
	const ist::PressurePair pair{contact.constants.k, contact.constants.weightA, contact.constants.weightB};
	const ist::Wrench aboutOrigin = ist::pressureWrench(sums, pair);
	const double force = norm(aboutOrigin.force);
	if (!(sums.volume > 0) || !(force > 0) || !isFinite(aboutOrigin)) return false;

	const ist::Mat3& R_WA = contact.X_WA.rotation;
	const ist::Vec3 centroid = sums.firstMoment / sums.volume;
	patch.point = contact.X_WA * (contact.treeA->origin + centroid);
	patch.normal = R_WA * (aboutOrigin.force / force);
	patch.wrench = {R_WA * aboutOrigin.force, R_WA * (aboutOrigin.torque - cross(centroid, aboutOrigin.force))};

	const Eigen::Vector3d c = toEigen(centroid), n = toEigen(patch.normal);
	const Matrix3 R = toEigen(R_WA);
	const Matrix3 spread = R * covariance(sums, c) * R.transpose();
	const double radiusSquared = std::max(spread.trace() - n.dot(spread * n), 0.0);
	patch.frictionRadius = kFrictionRadiusPerRms * std::sqrt(radiusSquared);

	patch.frictionFactor = ist::frictionFactor(sums);

	const double length = std::max(std::sqrt(radiusSquared), 1e-3 * std::cbrt(sums.volume));
	const ist::SymmetricMatrix6 exact = movedToWorld(ist::pressureStiffness(sums, pair), R, c);
	patch.stiffness = ist::projectedPositive(exact, length);
	const double kept = traceOfForces(patch.stiffness),
				 share = kept > 0 ? std::clamp(kMostAdded * traceOfForces(exact) / kept, 0.0, 1.0) : 1;
	for (double& s : patch.stiffness.m) s *= share;

	patch.damping = ist::SymmetricMatrix6();
	if (!(contact.constants.dissipation > 0)) return true;
	ist::SymmetricMatrix6 damping = movedToWorld(ist::pressureDamping(sums, pair), R, c);
	for (double& d : damping.m) d *= contact.constants.dissipation;
	patch.damping = ist::projectedPositive(damping, length);
	return true;
}

void btContactLoad::addApproach(const btISTContact& contact, int patchIndex, double speed)
{
	const double area = norm(contact.patches[patchIndex].areaVector);
	m_areaTimesSpeed += area * std::max(0.0, speed);
	m_area += area;
}

double stiffnessUnder(const btPress& press, double least, double former, double h)
{
	// At rest the present depth asks for the same k. In a contact that has just begun, or in the slivers of a fit, the area says little,
	// but the depth shows that nothing presses.
	double pressed = press.force / (press.area * press.aimed);
	if (former > 0) pressed = std::min(pressed, former * press.depth / press.aimed);
	double needed = std::max(least, pressed);
	if (former > 0) needed = std::min(needed, former * std::exp(mostGrowth(h)));
	return std::max(needed, std::min(former, std::max(kSpare * needed, former * std::exp(-kDecay * h))));
}

double carryLoad(btISTContact& contact, const btContactLoad& load, double h)
{
	btISTPairConstants& constants = contact.constants;
	if (!(constants.load > 0)) return 1;
	const double asked = constants.k, area = pressedArea(contact);
	if (load.weight > constants.load)
	{
		constants.k *= load.weight / constants.load;
		constants.load = load.weight;
		constants.rule = btISTStiffnessRule::PileLoad;
	}
	const auto raiseTo = [&](double k) {
		if (!(k > constants.k) || !std::isfinite(k)) return;
		constants.k = k;
		constants.rule = btISTStiffnessRule::Pressed;
	};
	const double former = contact.grown;
	// Bodies that begin inside one another may use the energy of a soft contact only.
	const bool isNew = !contact.tank.open && !(contact.ahead > 0);
	// Held bodies press as much as k says: for them any depth is the aimed one.
	double depth = ist::meanDepth(contact.total);
	if (!(former > 0)) raiseTo(load.motor / (area * std::max(depth, constants.depth)));
	if (former > 0 && isClamped(contact, h)) depth = std::min(depth, constants.depth);
	raiseTo(stiffnessUnder({norm(contact.pressed), area, depth, constants.depth}, constants.k, former, h));
	if (!isNew) raiseTo(stiffnessOfStop(contact, load, area, h));
	fillEnergyTank(contact, former);
	const double stiffest = kStiffestPerStep * restingMass(contact, load.mass) / (h * h * area);
	if (constants.k > stiffest)
	{
		constants.k = stiffest;
		constants.rule = btISTStiffnessRule::StepBound;
	}
	contact.grown = constants.k;
	const double factor = constants.k / asked;
	contact.error.force *= factor;
	return factor;
}

void notePressed(ist::Vec3& pressed, const ist::Vec3& normalImpulse, double h)
{
	const ist::Vec3 change = -std::expm1(-h / kPressedTime) * (normalImpulse / h - pressed);
	if (isFinite(change)) pressed += change;
}

void notePressed(btISTContact& contact, const ist::Vec3& normalImpulse, double h) { notePressed(contact.pressed, normalImpulse, h); }

void leaveOutRolling(btContactPatch& patch, const btISTContact& contact, double curvature, const ist::Vec3& spin, double h)
{
	const double moment = norm(patch.wrench.force) / curvature;
	const double rolled = h / curvature * norm(spin - dot(spin, patch.normal) * patch.normal);
	const double beyond = moment * kRolledPerRadius * rolled / patch.frictionRadius;
	if (!(moment > 0) || !std::isfinite(beyond)) return;
	Matrix3 K;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) K(i, j) = patch.stiffness(3 + std::min(i, j), 3 + std::max(i, j));
	const RollingAxes axes(K, patch.normal);
	scaleRotations(patch.stiffness, axes.without(moment + beyond));
	if (contact.constants.freeRolling) scaleRotations(patch.damping, axes.without(kDampedRolling * beyond));
}

void leaveOutSliding(btContactPatch& patch, const ist::SymmetricMatrix6& response, int patches, double h)
{
	ist::SymmetricMatrix6& K = patch.stiffness;
	const auto along = [&K](const ist::Vec3& a, const ist::Vec3& b) { return dot(a, (K * ist::Twist{b, {}}).force); };
	ist::Vec3 u, v;
	ist::completeFrame(patch.normal, u, v);
	const ist::PlaneAxes axes(along(u, u), along(v, v), along(u, v));
	const double c = std::cos(axes.angle), s = std::sin(axes.angle), leastCurved = kFlatStiffness * along(patch.normal, patch.normal);
	const double mostExplicit = h < 1.5 * kTick ? kMostExplicitInTick : kMostExplicit;
	for (const ist::Vec3& t : {c * u + s * v, c * v - s * u})
	{
		const ist::Wrench held = K * ist::Twist{t, {}};
		const double stiffness = dot(t, held.force);
		if (!(stiffness > leastCurved)) continue;
		const double q[6] = {held.force.x, held.force.y, held.force.z, held.torque.x, held.torque.y, held.torque.z};
		double yields = 0;
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) yields += q[i] * response(std::min(i, j), std::max(i, j)) * q[j];
		const double lambda = h * h * yields / stiffness;
		if (!(lambda > 0) || !std::isfinite(lambda)) continue;
		const double share = std::min(1.0, mostExplicit / (patches * lambda)) / stiffness;
		for (int i = 0; i < 6; ++i)
			for (int j = i; j < 6; ++j) K(i, j) -= share * q[i] * q[j];
	}
}

double rollingCurvature(const btContactPatch& patch, const ist::Vec3& center, double side)
{
	const double height = side * dot(center - patch.point, patch.normal);
	return height > 0 ? 1 / height : std::numeric_limits<double>::infinity();
}

void multiply(btContactPatch& patch, double factor)
{
	patch.wrench = factor * patch.wrench;
	for (double& s : patch.stiffness.m) s *= factor;
	for (double& d : patch.damping.m) d *= factor;
}
