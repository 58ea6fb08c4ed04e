// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Law/btPaperLaw.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr int kPowerIterations = 60;

/// Motion and inverse inertia of a body, World axes. Zero inverses: the body is static or kinematic.
struct Mover
{
	ist::Vec3 center, velocity, spin, inverseMass;
	ist::Mat3 inverseInertia = ist::zeroMat3();

	explicit Mover(const btRigidBody& body)
		: center(toVec3(body.getWorldTransform().getOrigin())),
		  velocity(toVec3(body.getLinearVelocity())),
		  spin(toVec3(body.getAngularVelocity()))
	{
		if (body.isStaticOrKinematicObject()) return;
		inverseMass = double(body.getInvMass()) * toVec3(body.getLinearFactor());
		const btVector3& factor = body.getAngularFactor();
		for (int i = 0; i < 3; ++i)
			for (int j = 0; j < 3; ++j)
				inverseInertia.m[i][j] = double(factor[i]) * double(body.getInvInertiaTensorWorld()[i][j]) * double(factor[j]);
	}
	ist::Vec3 velocityAt(const ist::Vec3& p) const { return velocity + cross(spin, p - center); }
};

/// Sum of weight g g^T, where g is a direction of motion of both bodies: linear and angular of A, then of B.
struct MotionMatrix
{
	double m[12][12] = {};

	void add(double weight, const double* g)
	{
		for (int i = 0; i < 12; ++i)
			for (int j = 0; j < 12; ++j) m[i][j] += weight * g[i] * g[j];
	}
};

/// Largest eigenvalue of M^-1 K by power iteration. K is a sum of squares, so the iteration converges from below.
double largestEigenvalue(const MotionMatrix& K, const Mover& A, const Mover& B)
{
	double x[12];
	// This start vector is not orthogonal to any eigenvector that the symmetry of a scene could produce.
	for (int i = 0; i < 12; ++i) x[i] = 1 + 0.37 * i - 0.061 * i * i;
	double eigenvalue = 0;
	for (int round = 0; round < kPowerIterations; ++round)
	{
		double f[12] = {}, energy = 0, square = 0;
		for (int i = 0; i < 12; ++i)
			for (int j = 0; j < 12; ++j) f[i] += K.m[i][j] * x[j];
		const ist::Vec3 v[4] = {componentProduct(A.inverseMass, {f[0], f[1], f[2]}), A.inverseInertia * ist::Vec3{f[3], f[4], f[5]},
			componentProduct(B.inverseMass, {f[6], f[7], f[8]}), B.inverseInertia * ist::Vec3{f[9], f[10], f[11]}};
		for (int i = 0; i < 12; ++i)
		{
			energy += f[i] * x[i];
			square += f[i] * v[i / 3][i % 3];
		}
		// Rayleigh's quotient of K^(1/2) M^-1 K^(1/2) at K^(1/2) x: (x.K M^-1 K x) / (x.K x). It never exceeds the largest eigenvalue.
		if (!(energy > 0) || !(square > 0)) return eigenvalue;
		eigenvalue = square / energy;
		for (int i = 0; i < 12; ++i) x[i] = v[i / 3][i % 3] / eigenvalue;
	}
	return eigenvalue;
}
}  // namespace

btPaperLaw::btPaperLaw(int pairCapacity)
	: m_workspace([&] {
		  ist::QueryCapacity capacity;
		  capacity.pairs = std::max(pairCapacity, 1);
		  return capacity;
	  }())
{}

std::optional<ist::Error> btPaperLaw::add(btRigidBody* A, std::shared_ptr<const ist::InnerSphereTree> treeA, btRigidBody* B,
	std::shared_ptr<const ist::InnerSphereTree> treeB, const btPaperMaterial& material)
{
	if (!treeA || !treeB || treeA->inner.empty() || treeB->inner.empty())
		return ist::Error{"the paper's law needs a tree with inner spheres for each body"};
	for (const double constant : {material.epsilonC, material.epsilonD})
		if (!std::isfinite(constant) || constant < 0) return ist::Error{"epsilon_c and epsilon_d must be finite numbers, 0 or more"};
	return m_pairs.add({A, B, std::move(treeA), std::move(treeB), material, {}});
}

void btPaperLaw::evaluate(Pairs::Pair& pair, double h)
{
	btPaperContact& contact = pair.contact;
	contact = btPaperContact();
	const ist::Pose X_WA = toRigidPose(pair.A->getWorldTransform()), X_WB = toRigidPose(pair.B->getWorldTransform());
	ist::QueryOptions options;
	options.model = ist::Model::Inner;
	options.stiffness = options.patches = false;
	options.sortPairs = true;
	const ist::OverlapResult overlap = ist::queryOverlap(*pair.treeA, *pair.treeB, ist::inverse(X_WA) * X_WB, m_workspace, options);
	contact.complete = overlap.status == ist::QueryStatus::Ok && overlap.pairListComplete;
	if (!contact.complete) return;
	contact.pairs = overlap.pairCount;
	for (int k = 0; k < overlap.pairCount; ++k) contact.volume += double(overlap.pairs[k].lens);
	if (!(contact.volume > 0)) return;

	const Mover A(*pair.A), B(*pair.B);
	MotionMatrix K, D;
	for (int k = 0; k < overlap.pairCount; ++k)
	{
		const ist::OverlapPair& p = overlap.pairs[k];
		const ist::Vec3 n = X_WA.rotation * p.normal, C = X_WA * (pair.treeA->origin + p.centroid);
		const double velocity = dot(A.velocityAt(C) - B.velocityAt(C), n), share = double(p.lens) / contact.volume;
		const double force = double(p.lens) * pair.material.epsilonC - velocity * pair.material.epsilonD * share;
		const ist::Vec3 armA = cross(C - A.center, n), armB = cross(C - B.center, n);
		const double g[12] = {n.x, n.y, n.z, armA.x, armA.y, armA.z, -n.x, -n.y, -n.z, -armB.x, -armB.y, -armB.z};
		K.add(pair.material.epsilonC * double(p.area), g);
		D.add(pair.material.epsilonD * share, g);
		if (!(force > 0))
		{
			++contact.held;
			continue;
		}
		contact.onA = contact.onA + force * ist::Wrench{n, armA};
		contact.onB = contact.onB - force * ist::Wrench{n, armB};
	}
	contact.stability = h * h * largestEigenvalue(K, A, B) + 2 * h * largestEigenvalue(D, A, B);
}

void btPaperLaw::apply(double h)
{
	for (Pairs::Pair& pair : m_pairs.all())
	{
		evaluate(pair, h);
		const btPaperContact& contact = pair.contact;
		m_refused += !contact.complete;
		m_unstable += contact.stability > 4;
		if (contact.pairs > 0) exertExplicitly(*pair.A, contact.onA, *pair.B, contact.onB);
	}
}
