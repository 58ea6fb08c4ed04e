// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Contact/btISTContactCache.h"

#include "BulletISTCollision/Contact/btISTContactStore.h"
#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Base/SamePose.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Force/RelativeMotion.h"
#include "BulletISTCollision/Core/Query/LeafClearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
constexpr double kShareOfError = 0.25, kShareOfLength = 0.25;
constexpr double kLeastTrust = 1.0 / 64, kRegain = 1.5;

double volumeOfB(const btISTContact& c) { return c.treeB ? c.treeB->volume : c.volumeB; }

double smallerVolume(const btISTContact& c) { return std::min(c.treeA->volume, volumeOfB(c)); }

/// Force floor for k = 1.
double floorOf(const btISTContact& c) { return ist::forceFloor(c.treeA->volume, volumeOfB(c)); }

/// Weights of the pressure law, with k = 1.
ist::PressurePair weightsOf(const btISTContact& c) { return {1, c.constants.weightA, c.constants.weightB}; }

ist::Vec3 forceOf(const btISTContact& c) { return ist::pressureWrench(c.total, weightsOf(c)).force; }

double referenceForce(const btISTContact& c) { return std::max(norm(forceOf(c)), floorOf(c)); }

/// Distance of the rim of the contact from its centroid, from the spread of the overlap [m].
double rimOf(const ist::OverlapIntegrals& total)
{
	constexpr double kRimPerRms = 2;  // 1.4 for a disc
	const ist::Vec3 centroid = total.firstMoment / total.volume;
	const double square = (total.secondMoment[0] + total.secondMoment[1] + total.secondMoment[2]) / total.volume - dot(centroid, centroid);
	return kRimPerRms * std::sqrt(std::max(square, 0.0));
}

/// Way after which what does not touch yet may matter [m].
double motionLimit(const btISTContact& c, double tolerance)
{
	const double errors = kShareOfLength * (c.treeA->errorLength() + (c.treeB ? c.treeB->errorLength() : 0));
	// Contact of surfaces may be shallower than the errors of leaves. Another place then gets no deeper than the way.
	return c.total.surfaceVolume > 0 ? std::min(errors, tolerance * ist::meanDepth(c.total)) : errors;
}
}  // namespace

double btISTCachedResult::floorForce(const btISTContact& contact) { return contact.constants.k * floorOf(contact); }

btISTCachedResult::Use btISTCachedResult::use(
	btISTContact& contact, const Measures& measures, uint64_t version, const btISTContactCache& contactCache)
{
	m_hasPrediction = false;
	if (!contactCache.on || !m_valid || version != m_version || measures != m_measures || !isRigid(contact.X_AB)) return Ask;
	const bool tolerant = contactCache.maxError > 0;
	// Sums that have followed the motion are those of the last pose, also where no error is granted any more.
	if (ist::isSame(contact.X_AB, m_X_last) && (tolerant || ist::isSame(contact.X_AB, m_X_asked))) return Still;
	if (contact.patchCount == 0)
	{
		const bool far = isFar(contact);
		if (far) m_pause = 0;
		return far ? Apart : Ask;
	}
	return tolerant && follow(contact, contactCache.maxError) ? Moved : Ask;
}

bool btISTCachedResult::wantsClearance()
{
	constexpr uint8_t kLongestPause = 15;
	if (m_skipped < m_pause) return ++m_skipped, false;
	m_skipped = 0;
	m_pause = std::min(uint8_t(2 * m_pause + 1), kLongestPause);
	return true;
}

bool btISTCachedResult::isFar(const btISTContact& contact) const
{
	if (!(m_clearance > 0)) return false;
	const ist::InnerSphereTree &A = *contact.treeA, *B = contact.treeB.get();
	// Each body's motion is bounded in the frame of the other; the smaller bound counts.
	double way = ist::farthestMotion(inverse(m_X_asked), inverse(contact.X_AB), A.origin, ist::reachOf(A));
	if (B) way = std::min(way, ist::farthestMotion(m_X_asked, contact.X_AB, B->origin, ist::reachOf(*B)));
	return way < m_clearance;
}

/// Moves the sums to first order. Returns false when they are not accurate enough any more.
bool btISTCachedResult::follow(btISTContact& contact, double tolerance)
{
	// Limit of the force change, as a share of the reference force, and of the rotation [rad].
	const double allowed = kShareOfError * tolerance * m_trust;
	constexpr double kWorthLearning = 2;  // far beyond the limits, the error of the first order is not measured
	if (!(contact.total.volume > 0)) return false;
	const ist::Vec3 &origin = contact.treeA->origin, centroid = contact.total.firstMoment / contact.total.volume;
	const ist::Twist sinceAsked = ist::motionOfB(m_X_asked, contact.X_AB, origin + centroid);
	// A shallow contact that tilts opens at its rim.
	const double turned = norm(sinceAsked.angular), way = norm(sinceAsked.linear) + turned * rimOf(contact.total);
	const double moved = std::max(turned / allowed, way / (m_trust * motionLimit(contact, tolerance)));
	if (!(moved <= kWorthLearning)) return false;

	const ist::Twist motion = ist::motionOfB(m_X_last, contact.X_AB, origin);
	ist::moveB(contact.total, motion);
	for (int i = 0; i < contact.patchCount; ++i) ist::moveB(contact.patches[i], motion);
	m_X_last = contact.X_AB;
	const double used = std::max(moved, change(contact) / allowed);
	m_predicted = forceOf(contact);
	m_hasPrediction = used <= kWorthLearning;
	return used <= 1;
}

/// Sum over all patches of the force changes since the query, or of the torque changes divided by the size, as a share of the reference
/// force. The larger of the two counts.
double btISTCachedResult::change(const btISTContact& contact) const
{
	double force = 0, torque = 0;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		const ist::OverlapIntegrals& patch = contact.patches[i];
		if (!(patch.volume > 0)) return std::numeric_limits<double>::infinity();
		const ist::Wrench by = contact.constants.weightB * (patch.normalB - m_normalB[i]) -
			contact.constants.weightA * (patch.normalA - m_normalA[i]);
		force += norm(by.force);
		torque += norm(by.torque - cross(patch.firstMoment / patch.volume, by.force));
	}
	return std::max(force, torque / std::cbrt(smallerVolume(contact))) / referenceForce(contact);
}

void btISTCachedResult::judge(const btISTContact& contact, double granted)
{
	m_foundError = distance(m_predicted, forceOf(contact)) / referenceForce(contact);
	if (m_foundError > granted / 2) m_trust = std::max(m_trust / 2, kLeastTrust);
	else if (m_foundError < granted / 8) m_trust = std::min(m_trust * kRegain, 1.0);
}

void btISTCachedResult::keep(
	const btISTContact& contact, const Measures& measures, uint64_t version, double clearance, const btISTContactCache& contactCache)
{
	m_foundError = 0;
	if (m_hasPrediction) judge(contact, contactCache.maxError);
	m_hasPrediction = false;
	m_valid = contact.status == ist::QueryStatus::Ok;
	m_X_asked = m_X_last = contact.X_AB;
	m_measures = measures;
	m_version = version;
	m_clearance = clearance;
	for (int i = 0; i < contact.patchCount; ++i)
	{
		m_normalA[i] = contact.patches[i].normalA;
		m_normalB[i] = contact.patches[i].normalB;
	}
}
