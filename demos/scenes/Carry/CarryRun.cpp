// SPDX-License-Identifier: Zlib
#include "demos/scenes/Carry/CarryRun.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <algorithm>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kOffTable = 0.02, kNear = 0.02, kStraight = 0.2, kStill = 0.05;  // [m, m, rad, m/s]
constexpr double kSampleEvery = 0.02;

double angleBetween(const Mat3& a, const Mat3& b) { return norm(rotationVector(quaternion(a * transpose(b)))); }

/// Observes a run and judges it.
class CarryJudge
{
public:
	explicit CarryJudge(const CarryScene& scene) : m_scene(scene)
	{
		m_out.hands = int(scene.hands().size());
		m_out.felt = scene.felt();
		for (int i = 1; i < CarryScene::kObjects; ++i) m_start[i] = onBeam(CarryScene::Object(i));
	}

	void look()
	{
		const double time = m_scene.time();
		CarrySample now;
		now.time = time;
		now.height = beam().translation.y;
		now.tilt = angleBetween(beam().rotation, CarryScene::wantedBeam(time).rotation);
		bool touched = true;
		for (const CarryScene::Hand& hand : m_scene.hands())
		{
			const BulletHand::Touch touch = hand.hand->touch(m_scene.stepSize());
			for (const Vec3& force : touch.force) now.force = std::max(now.force, norm(force));
			now.felt = std::max(now.felt, norm(hand.felt.torque));
			touched = touched && touch.parts > 0;
		}
		m_out.peakForce = std::max(m_out.peakForce, now.force);
		if (time >= GraspMotion::kLifted && time <= GraspMotion::kTurnedBack) lookAtCarrying(now, touched);
		if (time >= GraspMotion::kShaken && time <= GraspMotion::kTurnedBack) lookAtRest();
		if (time + 1e-9 < m_nextSample) return;
		m_nextSample += kSampleEvery;
		m_out.samples.push_back(now);
	}

	CarryOutcome finish()
	{
		const Pose wanted = CarryScene::wantedBeam(m_scene.time());
		m_out.lifted = m_carried && m_held;
		m_out.off = distance(beam().translation, wanted.translation);
		m_out.arrived = m_out.off < kNear && angleBetween(beam().rotation, wanted.rotation) < kStraight;
		for (int i = 0; i < CarryScene::kObjects; ++i)
		{
			const auto object = CarryScene::Object(i);
			if (i > 0) m_out.arrived = m_out.arrived && distance(onBeam(object), m_start[i]) < kNear;
			m_out.arrived = m_out.arrived && double(m_scene.body(object).getLinearVelocity().length()) < kStill;
		}
		if (m_rests > 0) m_out.wristForce /= m_rests, m_out.wristTorque /= m_rests;
		m_out.energy = m_scene.energy();
		for (const CarryScene::Hand& hand : m_scene.hands()) m_out.complaints += hand.hand->trackingMonitor().complaints().sentence();
		return std::move(m_out);
	}

private:
	Pose beam() const { return m_scene.X_WM(CarryScene::kBeam); }
	/// Position of the object's mesh in the frame of the beam's mesh.
	Vec3 onBeam(CarryScene::Object object) const { return inverse(beam()) * m_scene.X_WM(object).translation; }

	void lookAtCarrying(const CarrySample& now, bool touched)
	{
		for (size_t i = 0; i < m_scene.hands().size(); ++i)
		{
			const Pose X_PB = inverse(toPose(m_scene.hands()[i].hand->body(kHandPart).getWorldTransform())) * beam();
			if (!m_carried) m_inPalm[i] = X_PB;
			m_out.slip = std::max(m_out.slip, distance(X_PB.translation, m_inPalm[i].translation));
			m_out.slipAngle = std::max(m_out.slipAngle, angleBetween(X_PB.rotation, m_inPalm[i].rotation));
		}
		m_carried = true;
		m_held = m_held && touched && now.height > kOffTable;
		m_out.tilt = std::max(m_out.tilt, now.tilt);
		for (int i = 1; i < CarryScene::kObjects; ++i)
			m_out.passengers = std::max(m_out.passengers, distance(onBeam(CarryScene::Object(i)), m_start[i]));
	}

	/// Adds the load of the wrists while the beam rests in the air, above the place where it is put down.
	void lookAtRest()
	{
		double force = 0, torque = 0;
		for (const CarryScene::Hand& hand : m_scene.hands())
		{
			force = std::max(force, norm(hand.felt.force));
			torque = std::max(torque, norm(hand.felt.torque));
		}
		m_out.wristForce += force;
		m_out.wristTorque += torque;
		++m_rests;
	}

	const CarryScene& m_scene;
	CarryOutcome m_out;
	Vec3 m_start[CarryScene::kObjects];
	Pose m_inPalm[2];
	double m_nextSample = 0;
	bool m_carried = false, m_held = true;
	int m_rests = 0;
};
}  // namespace

Result<CarryOutcome> runCarry(CarryScene& scene, int hands, Felt felt)
{
	if (auto error = scene.start(hands, felt)) return *error;
	CarryJudge judge(scene);
	while (scene.time() < GraspMotion::kEnd)
	{
		scene.step();
		judge.look();
	}
	return judge.finish();
}
}  // namespace scenes
