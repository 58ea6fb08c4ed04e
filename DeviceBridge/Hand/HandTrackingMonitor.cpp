// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandTrackingMonitor.h"

#include <algorithm>

using namespace ist;

namespace devicebridge
{
std::string HandComplaints::sentence() const
{
	std::string text;
	const auto add = [&](std::uint64_t count, const char* what) {
		if (count == 0) return;
		if (!text.empty()) text += "; ";
		text += std::string(what) + " in " + std::to_string(count) + " of " + std::to_string(ticks) + " ticks";
	};
	add(lost, "tracking was lost, and the hand stood still,");
	add(missingJoints, "joints were missing, and their parts stayed in their last place on the palm,");
	add(jumps, "the hand jumped, and was followed at the largest speed,");
	add(wrongSide, "the sample was of the other hand, and was not used,");
	for (std::size_t i = 0; i < faulty.size(); ++i)
	{
		const std::string why = std::string(describe(static_cast<HandSampleFault>(i))) + ", so the hand counted as lost,";
		if (static_cast<HandSampleFault>(i) != HandSampleFault::None) add(faulty[i], why.c_str());
	}
	return text;
}

namespace
{
bool isSame(const HandState& a, const HandState& b)
{
	for (std::size_t i = 0; i < kHandJoints; ++i)
	{
		const HandJoint &x = a.joints[i], &y = b.joints[i];
		const Quaternion &p = x.orientation, &q = y.orientation;
		if (x.tracked != y.tracked || !(x.position == y.position) || p.x != q.x || p.y != q.y || p.z != q.z || p.w != q.w) return false;
	}
	return true;
}
}  // namespace

HandSampleFault HandTrackingMonitor::judge(const HandState& hand, double dt) noexcept
{
	m_sameFor = isSame(hand, m_sample) ? m_sameFor + dt : 0;
	if (m_sameFor == 0) m_sample = hand;
	const HandSampleFault fault = faultOf(hand, m_model.shape);
	if (fault != HandSampleFault::None) return fault;
	return m_limits.frozenAfter > 0 && m_sameFor > m_limits.frozenAfter ? HandSampleFault::Frozen : HandSampleFault::None;
}

HandTrackingMonitor::HandTrackingMonitor(const HandModel& model, const HandPartPoses& start, const HandTrackingLimits& limits)
	: m_model(model),
	  m_limits(limits),
	  m_last(start)
{
	for (std::size_t i = 0; i < kHandParts; ++i) m_targets[i].X_WB = start.X_WB[i];
}

/// Returns false if the limits held the target back.
bool HandTrackingMonitor::moveTowards(Target& target, const Pose& X_WB, double dt) const noexcept
{
	Vec3 way = X_WB.translation - target.X_WB.translation,
		 turn = rotationVector(quaternion(X_WB.rotation * transpose(target.X_WB.rotation)));
	const double length = norm(way), angle = norm(turn), furthest = m_limits.speed * dt, most = m_limits.turning * dt;
	const bool reaches = length <= furthest && angle <= most;
	if (length > furthest) way *= furthest / length;
	if (angle > most) turn *= most / angle;
	target.twist = {way / dt, turn / dt};
	if (reaches)
	{
		target.X_WB = X_WB;
		return true;
	}
	target.X_WB.translation += way;
	target.X_WB.rotation = rotationMatrix(quaternion(rotationMatrix(quaternionFromRotationVector(turn)) * target.X_WB.rotation));
	return false;
}

void HandTrackingMonitor::update(const HandState& hand, double dt) noexcept
{
	++m_complaints.ticks;
	const bool wrongSide = hand.left != m_model.shape.left;
	const HandSampleFault fault = wrongSide ? HandSampleFault::None : judge(hand, dt);
	const bool usable = !wrongSide && fault == HandSampleFault::None;
	const HandPartPoses now = usable ? handPartPoses(m_model, hand) : HandPartPoses();
	const bool palmKnown = now.known[kHandPart];
	if (wrongSide) ++m_complaints.wrongSide;
	else if (!usable) ++m_complaints.faulty[static_cast<std::size_t>(fault)];
	else if (!palmKnown) ++m_complaints.lost;

	m_lostFor = palmKnown ? 0 : m_lostFor + dt;
	if (palmKnown) m_grip = std::min(1.0, m_grip + 4 * dt / m_limits.fade);
	else if (m_lostFor > m_limits.patience) m_grip = std::max(0.0, m_grip - dt / m_limits.fade);

	bool missing = false, jumped = false;
	const Pose carried = palmKnown ? now.X_WB[kHandPart] * inverse(m_last.X_WB[kHandPart]) : Pose();
	for (std::size_t i = 0; i < kHandParts; ++i)
	{
		const bool known = palmKnown && now.known[i];
		missing = missing || (palmKnown && !known);
		Pose& wanted = m_last.X_WB[i];
		if (known) wanted = now.X_WB[i];
		else if (palmKnown)
		{
			wanted = carried * wanted;
			wanted.rotation = rotationMatrix(quaternion(wanted.rotation));
		}
		jumped = !moveTowards(m_targets[i], wanted, dt) || jumped;
	}
	if (missing) ++m_complaints.missingJoints;
	if (jumped) ++m_complaints.jumps;
}
}  // namespace devicebridge
