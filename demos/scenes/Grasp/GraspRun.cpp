// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspRun.h"

#include "BulletHapticForce/Law/btContactLaw.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <algorithm>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kSampleEvery = 0.01;
}  // namespace

Result<std::unique_ptr<GraspScene>> GraspScene::make(const GraspOptions& options)
{
	Result<GraspObject> object = options.mesh.empty() ? makeGraspObject(options.object) : loadGraspObject(options.mesh, options.file);
	if (!object) return object.error();
	const GloveHandSize size{options.left, options.handLength};
	Result<HandShape> shape = measureHand(posedHand({}, size));
	if (!shape) return shape.error();
	Result<std::shared_ptr<const HandModel>> model = buildHandModel(
		shape.value(), {options.handSpheres, options.cache, 0, options.progress});
	if (!model) return model.error();

	std::unique_ptr<GraspScene> scene(new GraspScene);
	scene->m_options = options;
	scene->m_object = std::move(object).value();
	scene->m_model = std::move(model).value();
	const GraspObject& o = scene->m_object;
	Result<GraspSolid> solid = GraspSolid::make(o.mesh, options.objectSpheres, options.cache, options.progress);
	if (!solid) return Error{o.name + ": " + solid.error().message, solid.error().cancelled};
	scene->m_solid = std::move(solid).value();
	scene->m_motion.size = size;
	scene->m_motion.gripX = o.gripX;
	scene->m_motion.gripZ = o.gripZ;
	scene->m_motion.gripHeight = o.gripHeight;
	scene->m_motion.width = o.width;
	scene->m_motion.squeeze = options.squeeze;
	if (auto error = scene->start(options.friction)) return *error;
	return scene;
}

GraspScene::~GraspScene() { leave(); }

void GraspScene::leave()
{
	if (!m_world) return;
	m_audit.reset();
	m_hand.reset();
	m_body.reset();
	m_world->bullet().removeRigidBody(m_ground.get());
	m_world.reset();
}

std::optional<Error> GraspScene::start(double friction)
{
	leave();
	m_time = 0;
	m_world = std::make_unique<btISTWorld>();
	m_groundShape = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0));
	m_ground = std::make_unique<btRigidBody>(btScalar(0), nullptr, m_groundShape.get());
	m_ground->setFriction(btScalar(1));
	m_world->bullet().addRigidBody(m_ground.get());

	Result<std::unique_ptr<GraspBody>> body = GraspBody::make(*m_world, m_solid, {}, m_object.mass, friction);
	if (!body) return body.error();
	m_body = std::move(body).value();

	Result<std::unique_ptr<BulletHand>> hand = BulletHand::create(
		*m_world, m_model, posedHand(m_motion.at(0), m_motion.size), m_options.hand);
	if (!hand) return hand.error();
	m_hand = std::move(hand).value();
	m_audit = std::make_unique<btEnergyAudit>(m_world->bullet(), m_world->contacts());
	return std::nullopt;
}

void GraspScene::step() { step(posedHand(m_motion.at(m_time + m_options.step), m_motion.size)); }

void GraspScene::step(const HandState& hand)
{
	m_hand->drive(hand, m_options.step);
	m_audit->beforeStep(m_options.step);
	m_world->step(m_options.step);
	m_audit->afterStep();
	m_time += m_options.step;
}

double GraspScene::addTouches(HeatMap& map) const
{
	return devicebridge::addTouches(map, *m_hand, m_world->contacts(), m_body->body(), m_body->X_BM(), m_options.step, m_options.step);
}

void GraspScene::addTouches(BulletHeatMapRounds& rounds) const
{
	rounds.step(*m_hand, m_world->contacts(), m_body->body(), m_body->X_BM(), m_options.step);
}

std::vector<GraspContact> GraspScene::graspContacts() const
{
	std::vector<GraspContact> contacts;
	const btRigidBody& body = m_body->body();
	const Pose X_BW = inverse(toPose(body.getWorldTransform()));
	for (const btISTContact* contact : m_world->contacts().contacts())
	{
		if (!touchedInLastStep(m_world->contacts(), *contact)) continue;
		const bool objectIsA = contact->bodyA == &body;
		if (!objectIsA && contact->bodyB != &body) continue;
		const btCollisionObject* other = objectIsA ? contact->bodyB : contact->bodyA;
		if (m_hand->partOf(other) < 0) continue;
		for (int i = 0; i < contact->patchCount; ++i)
		{
			btContactPatch patch;
			if (!evaluateContactPatch(*contact, i, patch)) continue;
			contacts.push_back({X_BW * patch.point, (objectIsA ? 1.0 : -1.0) * (X_BW.rotation * patch.normal),
				double(body.getFriction() * other->getFriction()) * patch.frictionFactor, patch.frictionRadius});
		}
	}
	return contacts;
}

namespace
{
/// Measures a grasp step by step and judges it.
class GraspJudge
{
public:
	GraspJudge(GraspScene& scene, double friction) : m_scene(scene), m_startHeight(height())
	{
		m_out.object = scene.object().name;
		m_out.friction = friction;
	}

	void look()
	{
		const BulletHand::Touch touch = m_scene.hand().touch(m_scene.stepSize());
		GraspSample now;
		now.time = m_scene.time();
		now.height = height() - m_startHeight;
		for (int i = 0; i < kHandParts; ++i)
		{
			now.force += norm(touch.force[i]);
			if (i == kHandPart) now.palm = norm(touch.force[i]);
			else now.strongest = std::max(now.strongest, norm(touch.force[i]));
			if (i != kHandPart) m_out.couplingForce = std::max(m_out.couplingForce, norm(m_scene.hand().coupling(i).force));
		}
		now.parts = touch.parts;
		now.pairs = double(touch.pairs);
		m_out.peakForce = std::max(m_out.peakForce, now.strongest);
		m_out.palmForce = std::max(m_out.palmForce, now.palm);
		lookAtSlip(now);
		lookAtGrip(now);
		lookAtHold(now);
		if (now.time + 1e-9 < m_nextSample) return;
		m_nextSample += kSampleEvery;
		m_out.samples.push_back(now);
	}

	GraspOutcome finish()
	{
		m_out.held = m_held;
		m_out.holdingForce = m_holds > 0 ? m_out.holdingForce / m_holds : 0;
		m_out.putDown = height() - m_startHeight < GraspOutcome::kOffTable && double(m_scene.body().getLinearVelocity().length()) < 0.05;
		m_out.energy = m_scene.energy();
		m_out.complaints = m_scene.hand().trackingMonitor().complaints().sentence();
		return std::move(m_out);
	}

private:
	double height() const { return double(m_scene.body().getWorldTransform().getOrigin().y()); }

	void lookAtSlip(GraspSample& now)
	{
		if (now.time < GraspMotion::kLifted || now.time > GraspMotion::kShaken) return;
		const Pose X_PB = inverse(toPose(m_scene.hand().body(kHandPart).getWorldTransform())) * toPose(m_scene.body().getWorldTransform());
		if (!m_lifted) m_X_PB = X_PB;
		m_lifted = true;
		now.slip = distance(X_PB.translation, m_X_PB.translation);
		m_out.slip = std::max(m_out.slip, now.slip);
		m_out.slipAngle = std::max(m_out.slipAngle, norm(rotationVector(quaternion(X_PB.rotation * transpose(m_X_PB.rotation)))));
		if (m_held && !(now.height > GraspOutcome::kOffTable && now.parts > 0))
		{
			m_held = false;
			m_out.lostAt = now.time;
			m_out.lostHeight = now.height;
		}
	}

	void lookAtGrip(const GraspSample& now)
	{
		if (!m_held || now.time < GraspMotion::kClosed || now.time > GraspMotion::kShaken) return;
		m_out.touched = m_out.touched || now.parts > 0;
		m_out.gripForce = std::max(m_out.gripForce, now.force);
	}

	/// Measures the hold while the object is still in the air, between turning and shaking.
	void lookAtHold(const GraspSample& now)
	{
		if (now.time < GraspMotion::kTurned || now.time > GraspMotion::kRested) return;
		m_out.holdingForce += now.force;
		if (m_holds++ > 0) return;
		m_out.parts = now.parts;
		GraspQualityOptions options;
		options.length = 0.5 * bounds(m_scene.object().mesh).longestSide();
		m_out.quality = graspQuality(m_scene.graspContacts(), options);
	}

	GraspScene& m_scene;
	GraspOutcome m_out;
	double m_startHeight, m_nextSample = 0;
	bool m_lifted = false, m_held = true;
	int m_holds = 0;
	Pose m_X_PB;
};
}  // namespace

Result<GraspOutcome> runGrasp(GraspScene& scene, double friction, const std::function<void()>& eachStep)
{
	if (auto error = scene.start(friction)) return *error;
	GraspJudge judge(scene, friction);
	while (scene.time() < GraspMotion::kEnd)
	{
		scene.step();
		judge.look();
		if (eachStep) eachStep();
	}
	return judge.finish();
}
}  // namespace scenes
