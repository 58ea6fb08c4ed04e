// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricIslands.h"

#include "BulletHapticForce/Law/btFlatPatch.h"
#include "BulletHapticForce/Solver/btSolverBodyMotion.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

using namespace btSolverBodyMotion;

namespace
{
constexpr double kCentralWay = 0.25;  // share of the thinner body that is left of a step after the first touch
constexpr double kOfCentre = 0.5;     // share of the speed at a touch that the motion of the centre of mass must give
constexpr int kMostSoftenings = 2;    // of contacts whose tanks hold less energy than they would return
}  // namespace

void btVolumetricIslands::reserve(size_t contacts)
{
	if (contacts <= m_reserved) return;
	m_reserved = std::max(contacts, 2 * m_reserved);
	const size_t patches = m_reserved * btISTContact::kMaxPatches;
	m_entries.reserve(patches);
	m_kept.reserve(patches);
	m_islands.reserve(patches);
	m_rows.reserve(patches);
	m_moved.reserve(2 * patches);
	reserve(m_passing);
	for (auto& block : m_lasting) reserve(*block);
}

void btVolumetricIslands::reserve(Block& block) const
{
	const size_t patches = std::min(m_reserved * btISTContact::kMaxPatches, size_t(kMaxBlockPatches));
	const size_t bodies = std::min(2 * m_reserved, size_t(kMaxBlockBodies));
	block.solver.reserve(int(bodies), int(patches));
	block.bodies.reserve(bodies);
	block.free.reserve(bodies);
	block.entries.reserve(patches);
}

void btVolumetricIslands::reserveBodies(size_t bodies)
{
	m_unrounded.reserve(bodies);
	m_held.reserve(bodies);
}

void btVolumetricIslands::clear()
{
	m_entries.clear();
	m_islands.clear();
	m_joints.clear();
	m_rows.clear();
	m_lastingCount = 0;
	m_heldToEnergyTanks = false;
}

bool btVolumetricIslands::isFinite(const btSolverBody& body)
{
	return ist::isFinite(twist(body)) && ist::isFinite(toVec3(body.getWorldTransform().getOrigin())) &&
		ist::isFinite(toVec3(body.internalGetInvMass()));
}

namespace
{
/// Component of a stiffness or damping along a direction [N/m, N s/m].
double along(const ist::SymmetricMatrix6& matrix, const ist::Vec3& n)
{
	double sum = 0;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) sum += n[i] * matrix(std::min(i, j), std::max(i, j)) * n[j];
	return sum;
}

/// Makes a point of the patch, which pushes along its normal, with a stiffness of at least `least` [N/m].
void keepNormal(btContactPatch& patch, double least)
{
	const ist::Vec3& n = patch.normal;
	const auto reduce = [&](ist::SymmetricMatrix6& matrix, double size) {
		matrix = ist::SymmetricMatrix6();
		for (int i = 0; i < 3; ++i)
			for (int j = i; j < 3; ++j) matrix(i, j) = size * n[i] * n[j];
	};
	patch.wrench = {dot(patch.wrench.force, n) * n, {}};
	reduce(patch.stiffness, std::max(along(patch.stiffness, n), least));
	reduce(patch.damping, along(patch.damping, n));
}

/// Whether the stiffness of a contact was set, and its present sums push as a former patch did, along the same normal and as stiffly. The
/// two together would be stiffer than what was set.
bool replaces(const btISTContact& contact, const btContactPatch& former)
{
	constexpr double kSameDirection = 0.97;
	if (contact.constants.load > 0) return false;
	btContactPatch present;
	for (int i = 0; i < contact.patchCount; ++i)
		if (evaluateContactPatch(contact, i, present) && dot(present.normal, former.normal) > kSameDirection &&
			along(present.stiffness, former.normal) >= along(former.stiffness, former.normal))
			return true;
	return false;
}

/// Whether both push at one place in one direction, as patches of repeated solves do that differ by little.
bool saySame(const btContactPatch& a, const btContactPatch& b, double thickness)
{
	constexpr double kSameDirection = 0.97, kSamePlace = 0.25;  // of the thinner body's thickness
	return dot(a.normal, b.normal) > kSameDirection && distance(a.point, b.point) < kSamePlace * thickness;
}
}  // namespace

void btVolumetricIslands::keep(const btISTContact& contact)
{
	m_kept.erase(std::remove_if(m_kept.begin(), m_kept.end(), [&](const Entry& e) { return e.contact == &contact; }), m_kept.end());
	for (Entry e : m_entries)
	{
		if (e.contact != &contact || replaces(contact, e.patch)) continue;
		keepNormal(e.patch, 0);
		// A force that a way of the body's thickness would not change comes from beyond the other's middle.
		if (dot(e.patch.wrench.force, e.patch.normal) > contact.thickness() * along(e.patch.stiffness, e.patch.normal)) continue;
		e.kept = true;
		e.patchIndex = 0;
		e.impulse = e.elastic = ist::Wrench();
		const auto same = std::find_if(m_kept.begin(), m_kept.end(),
			[&](const Entry& k) { return k.contact == &contact && saySame(k.patch, e.patch, contact.thickness()); });
		if (same == m_kept.end()) m_kept.push_back(e);
		else if (dot(e.patch.wrench.force, e.patch.normal) > dot(same->patch.wrench.force, same->patch.normal)) *same = e;
	}
}

void btVolumetricIslands::add(btISTContact& contact, int bodyA, int bodyB, const btContactFriction& friction)
{
	const size_t before = m_entries.size();
	for (int i = 0; i < contact.patchCount; ++i)
	{
		Entry entry;
		if (!evaluateContactPatch(contact, i, entry.patch))
		{
			++m_statistics.patchesWithoutForce;
			continue;
		}
		++m_statistics.patches;
		entry.contact = &contact;
		entry.patchIndex = i;
		entry.bodyA = bodyA;
		entry.bodyB = bodyB;
		entry.friction = friction;
		m_entries.push_back(entry);
	}
	for (const Entry& e : m_kept)
		if (e.contact == &contact && m_entries.size() - before < btISTContact::kMaxPatches) m_entries.push_back(e);
}

int btVolumetricIslands::rootOf(int body)
{
	while (m_parent[size_t(body)] != body) body = m_parent[size_t(body)] = m_parent[size_t(m_parent[size_t(body)])];
	return body;
}

void btVolumetricIslands::findIslands(const btSolverBody* bodies, const std::vector<int>& touched)
{
	for (const Entry& e : m_entries)
		if (canMove(bodies[e.bodyA]) && canMove(bodies[e.bodyB])) m_parent[size_t(rootOf(e.bodyA))] = rootOf(e.bodyB);
	if (!m_joints.empty()) joinByJoints(bodies);
	for (int i = int(m_entries.size()) - 1; i >= 0; --i)
	{
		Entry& e = m_entries[size_t(i)];
		int& island = m_islandOfRoot[size_t(rootOf(canMove(bodies[e.bodyA]) ? e.bodyA : e.bodyB))];
		if (island < 0)
		{
			island = int(m_islands.size());
			m_islands.emplace_back();
		}
		e.next = m_islands[size_t(island)].first;
		m_islands[size_t(island)].first = i;
		++m_islands[size_t(island)].entryCount;
	}
	for (int body = 0; body < int(m_parent.size()); ++body)
	{
		const int island = canMove(bodies[body]) ? m_islandOfRoot[size_t(rootOf(body))] : -1;
		if (island >= 0) ++m_islands[size_t(island)].bodyCount;
	}
	for (const int body : touched)
	{
		const int island = canMove(bodies[body]) ? m_islandOfRoot[size_t(rootOf(body))] : -1;
		if (island >= 0) m_islands[size_t(island)].touched = true;
	}
	takeJoints(bodies);
}

void btVolumetricIslands::weigh(const btSolverBody* bodies)
{
	for (int body = 0; body < int(m_parent.size()); ++body)
	{
		const int index = canMove(bodies[body]) ? m_islandOfRoot[size_t(rootOf(body))] : -1;
		if (index < 0) continue;
		Island& island = m_islands[size_t(index)];
		const double mass = massOf(bodies[body]), gravity = double(bodies[body].m_originalBody->getGravity().length());
		if (gravity > 0) island.weight += mass * gravity;
		else island.weightlessMass += mass;
	}
}

/// Twist of A minus that of B at the patch's point, without the impulse of the contact. A body that others hold or deflect within this
/// step has the motion that they are supposed to give it.
ist::Twist btVolumetricIslands::freeTwist(const Entry& e, const btSolverBody* bodies)
{
	const btSolverBody &a = bodies[e.bodyA], &b = bodies[e.bodyB];
	const ist::Twist changeA = movedTo(e.contact->supposedA, a, e.patch.point), changeB = movedTo(e.contact->supposedB, b, e.patch.point);
	return twistAt(a, e.patch.point) + changeA - twistAt(b, e.patch.point) - changeB;
}

/// Decides the stiffness of contacts that follows from what they carry. The pair's rule sees only the two bodies of a pair, but the
/// others of a pile have weight too.
void btVolumetricIslands::carryLoads(const btSolverBody* bodies)
{
	weigh(bodies);
	findMotors(bodies);
	for (const Island& island : m_islands)
		forEachContact(island, [&](size_t first, int count) {
			const Entry& e = m_entries[first];
			btISTContact& contact = *e.contact;
			btContactLoad load;
			load.weight = island.weight + island.weightlessMass * contact.constants.gravity;
			load.mass = std::numeric_limits<double>::infinity();
			load.motor = std::max(m_motors[size_t(e.bodyA)], m_motors[size_t(e.bodyB)]);
			for (const int body : {e.bodyA, e.bodyB})
				if (const double mass = massOf(bodies[body]); mass > 0) load.mass = std::min(load.mass, mass);
			const auto last = m_entries.begin() + std::ptrdiff_t(first) + count;
			for (auto i = last - count; i != last && !i->kept; ++i)
				load.addApproach(contact, i->patchIndex, -dot(freeTwist(*i, bodies).linear, i->patch.normal));
			const double factor = carryLoad(contact, load, m_step);
			if (factor == 1) return;
			for (auto i = last - count; i != last && !i->kept; ++i) multiply(i->patch, factor);
		});
}

/// On what is flat, contact moves on with a body that rolls.
void btVolumetricIslands::leaveOutRolling(Entry& e, const btSolverBody* bodies) const
{
	if (!btIsFlatPatch(e.contact->patches[e.patchIndex])) return;
	double curvature = 0;
	for (int side = 0; side < 2; ++side)
	{
		const btSolverBody& body = bodies[side == 0 ? e.bodyA : e.bodyB];
		if (!canMove(body)) continue;
		curvature += rollingCurvature(e.patch, toVec3(body.getWorldTransform().getOrigin()), side == 0 ? 1 : -1);
	}
	::leaveOutRolling(e.patch, *e.contact, curvature, freeTwist(e, bodies).angular, m_step);
}

/// With nothing set, the step does not brake what slides or rolls in a hollow either. A stiffness that was set keeps what it did.
void btVolumetricIslands::leaveOutSlidingAndRolling(const btSolverBody* bodies)
{
	m_patchesOf.assign(m_parent.size(), 0);
	for (const Entry& e : m_entries)
		for (const int body : {e.bodyA, e.bodyB}) m_patchesOf[size_t(body)] += canMove(bodies[body]);
	for (Entry& e : m_entries)
	{
		if (e.kept) continue;
		if (!(e.contact->constants.load > 0))
		{
			leaveOutRolling(e, bodies);
			continue;
		}
		const int patches = std::max(m_patchesOf[size_t(e.bodyA)], m_patchesOf[size_t(e.bodyB)]);
		const ist::SymmetricMatrix6 response = relativeResponse(rowBody(bodies[e.bodyA]), rowBody(bodies[e.bodyB]), e.patch.point);
		leaveOutSliding(e.patch, response, patches, m_step);
		leaveOutRolling(e, bodies);
		leaveOutSliding(e.patch, response, patches, m_step);  // without the moment of rolling, more of it is soft
	}
}

/// Moves the wrenches of bodies that do not touch yet back to their present poses: there the spring of the contact pulls by as much as
/// it lacks until the touch, and the solver leaves it out as long as it pulls. Where others hold or deflect a body, patches are points that
/// push along their normals.
void btVolumetricIslands::waitForTouch(const btSolverBody* bodies)
{
	for (Entry& e : m_entries)
	{
		const double ahead = e.contact->ahead;
		if (e.kept || !(ahead > 0)) continue;
		// If they resisted rotations, all of several could come to pull, and the bodies would pass through each other.
		if (e.contact->deflected || e.contact->supposesOthers())
			keepNormal(e.patch, norm(e.patch.wrench.force) / ist::meanDepth(e.contact->patches[e.patchIndex]));
		const double speed = -dot(freeTwist(e, bodies).linear, e.patch.normal);
		if ((m_step - ahead) * speed > kCentralWay * e.contact->thickness()) centre(e, bodies, speed);
		e.patch.wrench = e.patch.wrench + ahead * (e.patch.stiffness * freeTwist(e, bodies));
	}
}

/// Lets a patch push on the centre of mass of the faster body. A body that is stopped at a corner would turn about it, and could go
/// through the other in what is left of a long step. Where it is a spin that brings the bodies together, at `speed` [m/s], the patch stays.
void btVolumetricIslands::centre(Entry& e, const btSolverBody* bodies, double speed)
{
	const ist::Twist a = twist(bodies[e.bodyA]), b = twist(bodies[e.bodyB]);
	const btSolverBody& faster = bodies[squaredNorm(a.linear) < squaredNorm(b.linear) ? e.bodyB : e.bodyA];
	const ist::Vec3 way = toVec3(faster.getWorldTransform().getOrigin()) - e.patch.point, &n = e.patch.normal;
	Entry centred = e;
	centred.patch.point = e.patch.point + way - dot(way, n) * n;
	if (-dot(freeTwist(centred, bodies).linear, n) < kOfCentre * speed) return;
	e.patch.point = centred.patch.point;
	e.patch.wrench.torque = {};
	for (ist::SymmetricMatrix6* matrix : {&e.patch.stiffness, &e.patch.damping})
		for (int i = 0; i < 6; ++i)
			for (int j = std::max(i, 3); j < 6; ++j) (*matrix)(i, j) = 0;
}

bool btVolumetricIslands::fitsBlock(const Island& island)
{
	return island.bodyCount <= kMaxBlockBodies && island.entryCount <= kMaxBlockPatches;
}

/// Corrects the wrenches for the rounding of poses: the query uses rounded poses, and the stiffness gives the rest to first order.
void btVolumetricIslands::displaceByRounding(const btSolverBody* bodies)
{
	m_moved.clear();
	const auto lacking = [&](int body, const ist::Vec3& point) {
		if (!canMove(bodies[body])) return ist::Twist();
		m_moved.push_back(bodies[body].m_originalBody);
		return movedTo(m_unrounded.recall(*m_moved.back(), m_stepNumber), bodies[body], point);
	};
	for (Entry& e : m_entries)
	{
		if (e.kept) continue;
		const ist::Twist a = lacking(e.bodyA, e.patch.point), b = lacking(e.bodyB, e.patch.point);
		e.patch.wrench = e.patch.wrench - e.patch.stiffness * (a - b);
	}
}

void btVolumetricIslands::hold(int body, double time)
{
	const int index = m_islandOfRoot[size_t(rootOf(body))];
	if (index < 0) return;
	double& moves = m_islands[size_t(index)].moves;
	moves = std::min(moves, time);
}

namespace
{
/// Takes from the body's speed what its weight and other forces of the step have given it in the last `time` [s]: it does not move then, so
/// they do no work. A body at rest stays at rest. Returns the change of its energy [J].
double takeBackWork(btSolverBody& body, double time, double step)
{
	const ist::Vec3 v = twist(body).linear, given = time / step * toVec3(body.m_externalForceImpulse);
	if (!(squaredNorm(v) > 0)) return 0;
	const ist::Vec3 impulse = -massOf(body) * std::clamp(dot(given, v) / squaredNorm(v), -1.0, 1.0) * v;
	applyImpulse(body, {impulse, {}}, toVec3(body.getWorldTransform().getOrigin()));
	return 0.5 * dot(impulse, v + twist(body).linear);
}
}  // namespace

/// Notes the bodies of islands that do not move for the whole step. The change of their energy counts as work of a contact.
void btVolumetricIslands::holdBodies(btSolverBody* bodies)
{
	if (std::none_of(m_islands.begin(), m_islands.end(), [&](const Island& island) { return island.moves < m_step; })) return;
	for (int body = 0; body < int(m_parent.size()); ++body)
	{
		const int index = canMove(bodies[body]) ? m_islandOfRoot[size_t(rootOf(body))] : -1;
		if (index < 0 || !(m_islands[size_t(index)].moves < m_step)) continue;
		const Island& island = m_islands[size_t(index)];
		m_held.emplace_back(bodies[body].m_originalBody, m_step - island.moves);
		m_entries[size_t(island.first)].contact->work.elastic += takeBackWork(bodies[body], m_step - island.moves, m_step);
		++m_statistics.bodiesHeld;
	}
}

void btVolumetricIslands::settlePoses()
{
	for (const auto& [body, time] : m_held)
	{
		(void)m_unrounded.recall(*body, m_stepNumber);
		m_unrounded.takeBack(*body, time, m_step, m_stepNumber);
		m_unrounded.settle(*body, m_step, m_stepNumber);
	}
	m_held.clear();
	for (btRigidBody* body : m_moved) m_unrounded.settle(*body, m_step, m_stepNumber);
	m_moved.clear();
}

void btVolumetricIslands::prepare(const btSolverBody* bodies, int bodyCount, const std::vector<int>& touched, double h, uint64_t step)
{
	m_step = h;
	m_stepNumber = step;
	m_parent.resize(size_t(bodyCount));
	std::iota(m_parent.begin(), m_parent.end(), 0);
	m_islandOfRoot.assign(size_t(bodyCount), -1);
	m_indexInBlock.assign(size_t(bodyCount), -1);
	m_change.assign(size_t(bodyCount), ist::Twist());
	displaceByRounding(bodies);
	findIslands(bodies, touched);
	carryLoads(bodies);
	leaveOutSlidingAndRolling(bodies);
	waitForTouch(bodies);
	openEnergyTanks(bodies);
	for (const Island& island : m_islands)
	{
		++(fitsBlock(island) ? m_statistics.islands : m_statistics.islandsTooLarge);
		if (!fitsBlock(island)) makeRows(island, bodies);
		if (!fitsBlock(island) || !island.touched) continue;
		if (m_lastingCount == m_lasting.size())
		{
			m_lasting.push_back(std::make_unique<Block>());
			reserve(*m_lasting.back());
		}
		fill(*m_lasting[m_lastingCount++], island, bodies);
	}
}

void btVolumetricIslands::fill(Block& block, const Island& island, const btSolverBody* bodies)
{
	block.solver.clear();
	block.bodies.clear();
	block.entries.clear();
	block.jointRows.clear();
	const auto indexOf = [&](int body) {
		if (!canMove(bodies[body])) return -1;
		int& index = m_indexInBlock[size_t(body)];
		if (index < 0)
		{
			index = block.solver.addBody(rowBody(bodies[body]));
			block.bodies.push_back(body);
		}
		return index;
	};
	for (int i = island.first; i >= 0; i = m_entries[size_t(i)].next)
	{
		const Entry& e = m_entries[size_t(i)];
		const int a = indexOf(e.bodyA), b = indexOf(e.bodyB);
		const ist::Twist givenA = a < 0 ? twistAt(bodies[e.bodyA], e.patch.point) : ist::Twist();
		const ist::Twist givenB = b < 0 ? twistAt(bodies[e.bodyB], e.patch.point) : ist::Twist();
		const int patch = block.solver.addPatch(e.patch, a, b, givenA - givenB, m_step, e.friction);
		if (!e.kept) block.solver.startFriction(patch, m_step * e.contact->tank.friction[e.patchIndex]);
		block.entries.push_back(i);
	}
	for (int i = island.firstJoint; i >= 0; i = m_joints[size_t(i)].next)
	{
		indexOf(m_joints[size_t(i)].bodyA);
		indexOf(m_joints[size_t(i)].bodyB);
		addJointRows(block, m_joints[size_t(i)], bodies);
	}
	block.free.resize(block.bodies.size());
	block.impulses.resize(block.bodies.size());
}

void btVolumetricIslands::makeRows(const Island& island, const btSolverBody* bodies)
{
	for (int i = island.first; i >= 0; i = m_entries[size_t(i)].next)
	{
		const Entry& e = m_entries[size_t(i)];
		m_rows.emplace_back();
		m_rows.back().entry = i;
		m_rows.back().row.prepare(e.patch, rowBody(bodies[e.bodyA]), rowBody(bodies[e.bodyB]), m_step, e.friction);
	}
}

double btVolumetricIslands::solve(Row& r, btSolverBody* bodies)
{
	Entry& e = m_entries[size_t(r.entry)];
	const ist::Vec3& point = e.patch.point;
	const ist::Twist relative = twistAt(bodies[e.bodyA], point) - twistAt(bodies[e.bodyB], point);
	if (!ist::isFinite(relative)) return 0;  // by another row of Bullet: other bodies must not follow
	const ist::Wrench change = r.row.solve(relative);
	applyImpulse(bodies[e.bodyA], change, point);
	applyImpulse(bodies[e.bodyB], -1.0 * change, point);
	e.impulse = r.row.impulse();
	e.elastic = r.row.elasticImpulse();
	e.normalImpulse = r.row.normalImpulse();
	return dot(change.force, change.force);
}

double btVolumetricIslands::solve(Block& block, btSolverBody* bodies)
{
	for (size_t b = 0; b < block.bodies.size(); ++b) block.free[b] = twist(bodies[block.bodies[b]]);
	// Another row of Bullet may have led a body to that. The others must not follow.
	if (!std::all_of(block.free.begin(), block.free.end(), [](const ist::Twist& t) { return ist::isFinite(t); })) return 0;
	const auto takeBack = [&](int body, const ist::Wrench& impulse, const ist::Vec3& point) {
		if (!canMove(bodies[body])) return;
		ist::Twist& free = block.free[size_t(m_indexInBlock[size_t(body)])];
		free = free - response(rowBody(bodies[body]), impulse, point);
	};
	for (const int i : block.entries)
	{
		const Entry& e = m_entries[size_t(i)];
		takeBack(e.bodyA, e.impulse, e.patch.point);
		takeBack(e.bodyB, -1.0 * e.impulse, e.patch.point);
	}
	takeBackJoints(block, bodies);
	if (!block.solver.solve(block.free.data())) ++m_statistics.blocksNotFactorised;
	m_statistics.activeSetRounds += uint64_t(block.solver.rounds());
	m_statistics.activeSetsNotFound += block.solver.activeSetNotFound();
	m_statistics.frictionNotConverged += block.solver.frictionNotConverged();
	// They are summed in double precision: those of patches that press against each other are larger than what they leave of each other.
	std::fill(block.impulses.begin(), block.impulses.end(), ist::Wrench());
	double residual = sumJoints(block, bodies);
	const auto add = [&](int body, const ist::Wrench& impulse, const ist::Vec3& point) {
		if (!canMove(bodies[body])) return;
		const ist::Vec3 lever = point - toVec3(bodies[body].getWorldTransform().getOrigin());
		ist::Wrench& sum = block.impulses[size_t(m_indexInBlock[size_t(body)])];
		sum = sum + ist::Wrench{impulse.force, impulse.torque + cross(lever, impulse.force)};
	};
	for (size_t k = 0; k < block.entries.size(); ++k)
	{
		Entry& e = m_entries[size_t(block.entries[k])];
		const ist::Wrench impulse = block.solver.impulse(int(k)), change = impulse - e.impulse;
		add(e.bodyA, change, e.patch.point);
		add(e.bodyB, -1.0 * change, e.patch.point);
		e.impulse = impulse;
		e.elastic = block.solver.elasticImpulse(int(k));
		e.normalImpulse = block.solver.normalImpulse(int(k));
		residual = std::max(residual, dot(change.force, change.force));
	}
	for (size_t b = 0; b < block.bodies.size(); ++b)
	{
		btSolverBody& body = bodies[block.bodies[b]];
		applyImpulse(body, block.impulses[b], toVec3(body.getWorldTransform().getOrigin()));
	}
	return residual;
}

/// Solves an island whose bodies no other row moves. Returns the largest squared change of a force impulse.
double btVolumetricIslands::solvePassing(const Island& island, btSolverBody* bodies)
{
	double residual = 0;
	for (int softenings = 0;; ++softenings)
	{
		fill(m_passing, island, bodies);
		residual = std::max(residual, solve(m_passing, bodies));
		if (softenings == kMostSoftenings || !softenToEnergyTanks(island, bodies)) return residual;
		for (const int body : m_passing.bodies) m_indexInBlock[size_t(body)] = -1;
	}
}

double btVolumetricIslands::iterate(btSolverBody* bodies, int iteration)
{
	double residual = 0;
	for (size_t i = 0; i < m_lastingCount; ++i) residual = std::max(residual, solve(*m_lasting[i], bodies));
	for (Row& r : m_rows) residual = std::max(residual, solve(r, bodies));
	if (iteration > 0) return residual;
	for (const Island& island : m_islands)
		if (!island.touched && fitsBlock(island)) residual = std::max(residual, solvePassing(island, bodies));
	return residual;
}

void btVolumetricIslands::finish(btSolverBody* bodies)
{
	holdToEnergyTanks(bodies);
	for (const Island& island : m_islands) enterWork(island, bodies);
	for (const Entry& e : m_entries) std::fill(std::begin(e.contact->tank.friction), std::end(e.contact->tank.friction), ist::Wrench());
	for (const Entry& e : m_entries)
	{
		btISTContact& contact = *e.contact;
		contact.normalImpulse += e.normalImpulse;
		if (e.kept)
		{
			const ist::OverlapIntegrals& first = contact.patches[0];
			const ist::Vec3 lever = e.patch.point - contact.X_WA * (contact.treeA->origin + first.firstMoment / first.volume);
			contact.impulses[0] = contact.impulses[0] + ist::Wrench{e.impulse.force, e.impulse.torque + cross(lever, e.impulse.force)};
			continue;
		}
		contact.impulses[e.patchIndex] = e.impulse;
		contact.tank.friction[e.patchIndex] = (1 / m_step) * (e.impulse - e.elastic);
	}
	for (const Island& island : m_islands)
		forEachContact(island, [&](size_t first, int count) {
			ist::Vec3 sum;
			for (size_t i = first; i < first + size_t(count); ++i) sum += m_entries[i].normalImpulse * m_entries[i].patch.normal;
			notePressed(*m_entries[first].contact, sum, m_step);
		});
	holdBodies(bodies);
}
