// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/Solver/btVolumetricLinks.h"

#include "BulletHapticForce/Law/btFlatPatch.h"
#include "BulletHapticForce/Solver/btSolverBodyMotion.h"

#include "BulletDynamics/Featherstone/btMultiBody.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace btSolverBodyMotion;

namespace
{
using Six = double[6];

// A patch that bears a smaller share of a row's impulse hardly slows its convergence.
constexpr double kLittle = 0.5;
// Single precision does not know the response of loaded links better than this.
constexpr double kStiffest = 1e4;

void toArray(const ist::Vec3& a, const ist::Vec3& b, Six& out)
{
	const Six values = {a.x, a.y, a.z, b.x, b.y, b.z};
	std::copy(values, values + 6, out);
}

btVector3 unit(int axis) { return btVector3(axis == 0, axis == 1, axis == 2); }
}  // namespace

void btVolumetricLinks::clear()
{
	m_entries.clear();
	m_jacobians.clear();
	m_loaded.clear();
}

void btVolumetricLinks::setJoints(btMultiBodyConstraint* const* joints, int count)
{
	m_joints = joints;
	m_jointCount = count;
}

btVolumetricLinks::PlacedSide btVolumetricLinks::place(const Side& side, const ist::Vec3& point, btMultiBodyJacobianData& data)
{
	PlacedSide placed;
	static_cast<Side&>(placed) = side;
	if (!side.multiBody) return placed;
	const int n = side.multiBody->getNumDofs() + 6;
	placed.dofs = n;
	placed.velocity = side.multiBody->getCompanionId();
	if (placed.velocity < 0)
	{
		placed.velocity = data.m_deltaVelocities.size();
		side.multiBody->setCompanionId(placed.velocity);
		data.m_deltaVelocities.resize(placed.velocity + n, btScalar(0));
	}
	placed.jacobian = m_jacobians.size();
	m_jacobians.resize(m_jacobians.size() + 12 * size_t(n));
	// Bullet uses its arrays of the same names as scratch memory between its rows, so our numbers are copied out.
	const int at = data.m_jacobians.size();
	data.m_jacobians.resize(at + 2 * n);
	for (int row = 0; row < 6; ++row)
	{
		btScalar *J = &data.m_jacobians[at], *R = J + n;
		const btVector3 along = row < 3 ? unit(row) : btVector3(0, 0, 0), about = row < 3 ? btVector3(0, 0, 0) : unit(row - 3);
		side.multiBody->fillConstraintJacobianMultiDof(
			side.link, toBullet(point), about, along, J, data.scratch_r, data.scratch_v, data.scratch_m);
		side.multiBody->calcAccelerationDeltasMultiDof(J, R, data.scratch_r, data.scratch_v);
		double* out = &m_jacobians[placed.jacobian + size_t(row * n)];
		std::copy(J, J + n, out);
		std::copy(R, R + n, out + 6 * n);
	}
	data.m_jacobians.resize(at);
	return placed;
}

double btVolumetricLinks::responseOf(const PlacedSide& s, int dof, const double* impulse) const
{
	double change = 0;
	for (int row = 0; row < 6; ++row) change += impulse[row] * m_jacobians[s.jacobian + size_t((6 + row) * s.dofs + dof)];
	return change;
}

/// Adds to `motion` the change by an impulse on A and its opposite on B.
void btVolumetricLinks::addResponse(const Entry& e, const ist::Wrench& impulse, const btSolverBody* bodies, Motion& motion) const
{
	Six values;
	toArray(impulse.force, impulse.torque, values);
	for (int k = 0; k < 2; ++k)
	{
		const PlacedSide& s = e.side[k];
		const double sign = k == 0 ? 1 : -1;
		if (!s.multiBody)
		{
			motion.body[k] = motion.body[k] + response(rowBody(bodies[s.body]), sign * impulse, e.patch.point);
			continue;
		}
		for (int d = 0; d < s.dofs; ++d) motion.links[size_t(s.velocity + d)] += sign * responseOf(s, d, values);
	}
}

/// Twist of A minus that of B at the patch's point.
ist::Twist btVolumetricLinks::relative(const Entry& e, const btSolverBody* bodies, const Motion& motion) const
{
	ist::Twist result;
	for (int k = 0; k < 2; ++k)
	{
		const PlacedSide& s = e.side[k];
		ist::Twist t;
		if (s.multiBody)
		{
			Six u = {};
			for (int row = 0; row < 6; ++row)
				for (int d = 0; d < s.dofs; ++d)
					u[row] += m_jacobians[s.jacobian + size_t(row * s.dofs + d)] * motion.links[size_t(s.velocity + d)];
			t = {{u[0], u[1], u[2]}, {u[3], u[4], u[5]}};
		}
		else t = movedTo(motion.body[k], bodies[s.body], e.patch.point);
		result = k == 0 ? t : result - t;
	}
	return result;
}

/// J M^-1 J^T of the two sides together; both may belong to one multibody.
ist::SymmetricMatrix6 btVolumetricLinks::responseOf(const Entry& e, const btSolverBody* bodies)
{
	double W[6][6];
	for (int column = 0; column < 6; ++column)
	{
		std::fill(m_own.links.begin(), m_own.links.end(), 0.0);
		m_own.body[0] = m_own.body[1] = {};
		Six one = {};
		one[column] = 1;
		addResponse(e, {{one[0], one[1], one[2]}, {one[3], one[4], one[5]}}, bodies, m_own);
		const ist::Twist u = relative(e, bodies, m_own);
		Six values;
		toArray(u.linear, u.angular, values);
		for (int row = 0; row < 6; ++row) W[row][column] = values[row];
	}
	ist::SymmetricMatrix6 result;
	for (int i = 0; i < 6; ++i)
		for (int j = i; j < 6; ++j) result(i, j) = 0.5 * (W[i][j] + W[j][i]);
	return result;
}

/// Largest force along the normal of `e` with which a motor of its links can press [N].
double btVolumetricLinks::motorForce(const Entry& e) const
{
	double largest = 0;
	for (int i = 0; i < m_jointCount; ++i)
	{
		btMultiBodyConstraint& joint = *m_joints[i];
		if (joint.getConstraintType() != MULTIBODY_CONSTRAINT_1DOF_JOINT_MOTOR) continue;
		for (const PlacedSide& s : e.side)
		{
			if (!s.multiBody || joint.getMultiBodyA() != s.multiBody) continue;
			const int dof = 6 + s.multiBody->getLink(joint.getLinkA()).m_dofOffset;
			ist::Vec3 moved;  // velocity of the patch's point by a unit of the joint's
			for (int row = 0; row < 3; ++row) moved[row] = m_jacobians[s.jacobian + size_t(row * s.dofs + dof)];
			const double along = std::fabs(dot(moved, e.patch.normal)) / squaredNorm(moved);
			if (std::isfinite(along)) largest = std::max(largest, double(joint.getMaxAppliedImpulse()) / m_step * along);
		}
	}
	return largest;
}

/// Motion of both sides of `e`, with the impulses of all rows so far.
const btVolumetricLinks::Motion& btVolumetricLinks::state(const Entry& e, const btSolverBody* bodies, const btMultiBodyJacobianData& data)
{
	m_motion.links.resize(size_t(data.m_deltaVelocities.size()));
	for (int k = 0; k < 2; ++k)
	{
		const PlacedSide& s = e.side[k];
		if (!s.multiBody) m_motion.body[k] = twist(bodies[s.body]);
		else
			for (int d = 0; d < s.dofs; ++d)
				m_motion.links[size_t(s.velocity + d)] = double(s.multiBody->getVelocityVector()[d]) +
					double(data.m_deltaVelocities[s.velocity + d]);
	}
	return m_motion;
}

void btVolumetricLinks::apply(const Entry& e, const ist::Wrench& impulse, btSolverBody* bodies, btMultiBodyJacobianData& data) const
{
	Six values;
	toArray(impulse.force, impulse.torque, values);
	for (int k = 0; k < 2; ++k)
	{
		const PlacedSide& s = e.side[k];
		const double sign = k == 0 ? 1 : -1;
		if (!s.multiBody)
		{
			applyImpulse(bodies[s.body], sign * impulse, e.patch.point);
			continue;
		}
		data.scratch_r.resize(s.dofs);
		for (int d = 0; d < s.dofs; ++d)
		{
			data.scratch_r[d] = btScalar(sign * responseOf(s, d, values));
			data.m_deltaVelocities[s.velocity + d] += data.scratch_r[d];
		}
		s.multiBody->applyDeltaVeeMultiDof2(&data.scratch_r[0], btScalar(1));
		s.multiBody->setPosUpdated(false);
	}
}

void btVolumetricLinks::add(btISTContact& contact, const Side& a, const Side& b, const btContactFriction& friction, double h,
	const btSolverBody* bodies, btMultiBodyJacobianData& data, btVolumetricStatistics& statistics)
{
	m_step = h;
	const size_t first = m_entries.size();
	for (int i = 0; i < contact.patchCount; ++i)
	{
		Entry e;
		if (!evaluateContactPatch(contact, i, e.patch))
		{
			++statistics.patchesWithoutForce;
			continue;
		}
		e.contact = &contact;
		e.patchIndex = i;
		e.side[0] = place(a, e.patch.point, data);
		e.side[1] = place(b, e.patch.point, data);
		m_motion.links.resize(size_t(data.m_deltaVelocities.size()));
		m_own.links.resize(m_motion.links.size());
		if (!ist::isFinite(relative(e, bodies, state(e, bodies, data))))
		{
			++statistics.contactsNotFinite;
			m_entries.resize(first);
			return;
		}
		++statistics.patches;
		m_entries.push_back(e);
	}
	if (m_entries.size() == first) return;
	ist::SymmetricMatrix6 responses[btISTContact::kMaxPatches];
	double lightest = std::numeric_limits<double>::infinity();  // smallest effective mass that the patches push against along their normals
	for (size_t i = first; i < m_entries.size(); ++i)
	{
		const Entry& e = m_entries[i];
		responses[i - first] = responseOf(e, bodies);
		const double n[3] = {e.patch.normal.x, e.patch.normal.y, e.patch.normal.z};
		double moved = 0;
		for (int row = 0; row < 3; ++row)
			for (int column = 0; column < 3; ++column) moved += n[row] * responses[i - first](row, column) * n[column];
		if (moved > 0) lightest = std::min(lightest, 1 / moved);
	}
	btContactLoad load;
	load.mass = lightest;
	for (size_t i = first; i < m_entries.size(); ++i)
	{
		const Entry& e = m_entries[i];
		load.motor = std::max(load.motor, motorForce(e));
		load.addApproach(contact, e.patchIndex, -dot(relative(e, bodies, state(e, bodies, data)).linear, e.patch.normal));
	}
	const double factor = carryLoad(contact, load, h);
	for (size_t i = first; i < m_entries.size(); ++i)
	{
		multiply(m_entries[i].patch, factor);
		leaveOutRolling(m_entries[i], relative(m_entries[i], bodies, state(m_entries[i], bodies, data)).angular, h);
		m_entries[i].row.prepare(m_entries[i].patch, responses[i - first], h, friction);
	}
	const double speed = norm(relative(m_entries[first], bodies, state(m_entries[first], bodies, data)).linear);
	statistics.contactsTurnedOver += btContactEnergyTank::begin(contact, speed, h);
}

/// On what is flat, contact moves on with a body that rolls.
void btVolumetricLinks::leaveOutRolling(Entry& e, const ist::Vec3& spin, double h)
{
	if (!btIsFlatPatch(e.contact->patches[e.patchIndex])) return;
	double curvature = 0;
	for (const btCollisionObject* object : {e.contact->bodyA, e.contact->bodyB})
		if (!object->isStaticOrKinematicObject())
			curvature += rollingCurvature(e.patch, toVec3(object->getWorldTransform().getOrigin()), object == e.contact->bodyA ? 1 : -1);
	::leaveOutRolling(e.patch, *e.contact, curvature, spin, h);
}

void btVolumetricLinks::appendTouched(std::vector<int>& touched) const
{
	for (const Entry& e : m_entries)
		for (const PlacedSide& s : e.side)
			if (!s.multiBody) touched.push_back(s.body);
}

/// Relative twist at the patch by a unit impulse of the row, as far as it moves multibodies.
ist::Twist btVolumetricLinks::responseTo(const btMultiBodySolverConstraint& row, const Entry& e, const btMultiBodyJacobianData& data) const
{
	Six u = {};
	const auto add = [&](const btMultiBody* moved, int unitResponse) {
		for (int k = 0; k < 2; ++k)
		{
			const PlacedSide& s = e.side[k];
			if (!moved || s.multiBody != moved) continue;
			for (int i = 0; i < 6; ++i)
				for (int d = 0; d < s.dofs; ++d)
					u[i] += (k == 0 ? 1 : -1) * m_jacobians[s.jacobian + size_t(i * s.dofs + d)] *
						double(data.m_deltaVelocitiesUnitImpulse[unitResponse + d]);
		}
	};
	add(row.m_multiBodyA, row.m_jacAindex);
	add(row.m_multiBodyB, row.m_jacBindex);
	return {{u[0], u[1], u[2]}, {u[3], u[4], u[5]}};
}

void btVolumetricLinks::findLoaded(const btMultiBodyConstraintArray& rows, const btMultiBodyJacobianData& data)
{
	for (int i = 0; i < rows.size(); ++i)
	{
		const double alone = 1 / double(rows[i].m_jacDiagABInv);
		double most = 0;
		Loaded loaded;
		loaded.row = i;
		for (size_t k = 0; k < m_entries.size(); ++k)
		{
			const double borne = m_entries[k].row.borne(responseTo(rows[i], m_entries[k], data));
			if (!(borne > most)) continue;
			most = borne;
			loaded.patch = int(k);
		}
		if (!(most > kLittle * alone) || !std::isfinite(alone)) continue;
		loaded.stiffening = 1 / std::max(1 - most / alone, 1 / kStiffest);
		m_loaded.push_back(loaded);
	}
}

double btVolumetricLinks::visit(int patch, btSolverBody* bodies, btMultiBodyJacobianData& data)
{
	Entry& e = m_entries[size_t(patch)];
	const ist::Wrench change = e.row.solve(relative(e, bodies, state(e, bodies, data)));
	apply(e, change, bodies, data);
	e.impulse = e.row.impulse();
	e.elastic = e.row.elasticImpulse();
	e.normalImpulse = e.row.normalImpulse();
	return dot(change.force, change.force);
}

double btVolumetricLinks::iterate(btSolverBody* bodies, btMultiBodyJacobianData& data)
{
	double residual = 0;
	for (size_t i = 0; i < m_entries.size(); ++i) residual = std::max(residual, visit(int(i), bodies, data));
	return residual;
}

void btVolumetricLinks::sumChanges(const btSolverBody* bodies, const btMultiBodyJacobianData& data, std::vector<ist::Twist>& change)
{
	std::swap(m_changed, m_own.links);
	m_own.links.assign(size_t(data.m_deltaVelocities.size()), 0.0);
	for (const Entry& e : m_entries)
	{
		m_own.body[0] = m_own.body[1] = {};
		addResponse(e, e.impulse, bodies, m_own);
		for (int k = 0; k < 2; ++k)
			if (!e.side[k].multiBody) change[size_t(e.side[k].body)] = change[size_t(e.side[k].body)] + m_own.body[k];
	}
	std::swap(m_changed, m_own.links);
	m_own.links.resize(m_changed.size());
}

void btVolumetricLinks::holdToEnergyTank(size_t first, int count, btSolverBody* bodies, btMultiBodyJacobianData& data,
	std::vector<ist::Twist>& change, btVolumetricStatistics& statistics)
{
	std::fill(m_own.links.begin(), m_own.links.end(), 0.0);
	m_own.body[0] = m_own.body[1] = {};
	Entry* entries = &m_entries[first];
	for (int i = 0; i < count; ++i) addResponse(entries[i], entries[i].impulse, bodies, m_own);
	Motion& all = m_motion;
	btEnergyTankPatch patches[btISTContact::kMaxPatches];
	for (int i = 0; i < count; ++i)
	{
		const Entry& e = entries[i];
		const ist::Twist after = relative(e, bodies, state(e, bodies, data)), own = relative(e, bodies, m_own);
		all.links = m_changed;
		for (int k = 0; k < 2; ++k) all.body[k] = e.side[k].multiBody ? ist::Twist() : change[size_t(e.side[k].body)];
		patches[i] = {e.patch, e.impulse, e.elastic, after - relative(e, bodies, all), after, own};
	}
	btISTContactEnergyTank& tank = entries->contact->tank;
	const double share = btContactEnergyTank::share(btContactEnergyTank::scaledWork(patches, count), tank.stored);
	statistics.contactsHeldToEnergyTank += share < 1;
	for (int i = 0; share < 1 && i < count; ++i)
	{
		Entry& e = entries[i];
		const ist::Wrench less = (share - 1) * e.impulse;
		apply(e, less, bodies, data);
		m_own.body[0] = m_own.body[1] = {};
		std::swap(m_changed, m_own.links);
		addResponse(e, less, bodies, m_own);
		std::swap(m_changed, m_own.links);
		for (int k = 0; k < 2; ++k)
			if (!e.side[k].multiBody) change[size_t(e.side[k].body)] = change[size_t(e.side[k].body)] + m_own.body[k];
		btContactEnergyTank::hold(patches[i], share);
		e.impulse = patches[i].impulse;
		e.elastic = patches[i].elastic;
		e.normalImpulse *= share;
	}
	btContactEnergyTank::enter(tank, patches, count, m_step);
}

void btVolumetricLinks::writeFeedback(const Entry& e) const
{
	for (int k = 0; k < 2; ++k)
	{
		const PlacedSide& s = e.side[k];
		if (!s.multiBody) continue;
		const double perSecond = (k == 0 ? 1 : -1) / m_step;
		s.multiBody->setCompanionId(-1);
		const ist::Vec3 origin = toVec3(
			s.link < 0 ? s.multiBody->getBasePos() : s.multiBody->getLink(s.link).m_cachedWorldTransform.getOrigin());
		const btVector3 force = toBullet(perSecond * e.impulse.force);
		const btVector3 torque = toBullet(perSecond * (e.impulse.torque + cross(e.patch.point - origin, e.impulse.force)));
		if (s.link < 0)
		{
			s.multiBody->addBaseConstraintForce(force);
			s.multiBody->addBaseConstraintTorque(torque);
		}
		else
		{
			s.multiBody->addLinkConstraintForce(s.link, force);
			s.multiBody->addLinkConstraintTorque(s.link, torque);
		}
	}
}

void btVolumetricLinks::finish(
	btSolverBody* bodies, btMultiBodyJacobianData& data, std::vector<ist::Twist>& change, btVolumetricStatistics& statistics)
{
	for (size_t first = 0; first < m_entries.size();)
	{
		size_t end = first + 1;
		while (end < m_entries.size() && m_entries[end].contact == m_entries[first].contact) ++end;
		holdToEnergyTank(first, int(end - first), bodies, data, change, statistics);
		ist::Vec3 sum;
		for (size_t i = first; i < end; ++i) sum += m_entries[i].normalImpulse * m_entries[i].patch.normal;
		notePressed(*m_entries[first].contact, sum, m_step);
		first = end;
	}
	for (const Entry& e : m_entries)
	{
		e.contact->impulses[e.patchIndex] = e.impulse;
		e.contact->normalImpulse += e.normalImpulse;
		writeFeedback(e);
	}
}
