// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "DeviceBridge/Bullet/BulletDecoupledSource.h"

class btMultiBodyLinkCollider;

namespace devicebridge
{
class BulletLinks;
struct ShapeModel;

/// A body near a tool that the hand does not feel at all, or of which it does not feel some parts.
struct BulletUnfeltBody
{
	enum Reason
	{
		NoSlot,        ///< all slots of the hand are occupied (BulletDecoupledSettings::slots)
		NoPair,        ///< more parts are near the tool than eight for each slot
		NoModel,       ///< the shape has neither a tree nor a closed form: a mesh, a heightfield, a convex hull
		NoTree,        ///< neither the body nor the tool has a tree
		NotFinite,     ///< pose or velocity is not finite or not rigid
		NotSupported,  ///< a soft body
		WasScaled      ///< the shape was scaled after its tree was attached, so the tree does not fit
	};
	const btCollisionObject* body = nullptr;
	const BulletDecoupledSource* hand = nullptr;
	Reason reason = NoSlot;
	bool inPart = false;  ///< whether the hand feels other parts of the body

	/// A sentence that says why, and what to do.
	static const char* adviceFor(Reason reason);
};

/// The world's side of decoupled mode. Around each step of a Bullet world, it applies the impulses of the hands to the bodies. It then
/// shows the hands the bodies near their tools. Everything runs in the thread that owns the world, at any rate; it never waits.
///
/// Impulses enter as a force over the whole step, so that the implicit solver weighs them against everything that holds the body. So an
/// impulse that pressed a light body on a table for 0.2 s does not throw it. Bullet moves bodies by the velocity at the end of a step, as
/// if the whole impulse had come at its beginning. So the displacement is reduced by the share of time before the impulse was given.
///
/// The hand feels what the world itself treats as volumetric: trees, and Bullet's plane, box, sphere, capsule, cylinder and cone, also as
/// children of compounds, where body or tool has a tree. unfelt() names the bodies near a tool that it does not feel. If a pair filter is
/// set (btISTPairFilter), it feels only bodies whose pair with the tool is accepted. With a region, the bounding boxes of both after each
/// step decide whether the two can meet there. A body whose parts or trees have changed is released and felt anew. Some effects are
/// approximate: the hand's copies know a contact without a tree only by its impulse in the last step. They know a joint, and another hand
/// on the same body, only by the body's state after each step. So between two steps the hand feels the body without these. A link of a
/// multibody yields as it did in the last step in which hands pushed it, whatever held it then: joints, motors, limits or contacts. If
/// their pushes cancel, or other causes change the velocity more, the link yields as before.
class BulletWorldCoupling
{
public:
	explicit BulletWorldCoupling(btISTWorld& world) : BulletWorldCoupling(world.bullet(), world.registration(), world.materials()) {}
	/// The arguments must outlive this object. `rule` gives the constants of tool and body as it does for bodies of the world.
	BulletWorldCoupling(btDynamicsWorld& world, btISTRegistration& registration, const btISTPairRule& rule);
	~BulletWorldCoupling();

	/// Adds a hand; call it between steps. The hand must exist as long as this object takes steps, unless it is removed first. A hand that
	/// was in another coupling releases the bodies of that coupling. A hand that is here already stays as it is.
	void add(BulletDecoupledSource& hand);
	/// Removes a hand; call it while the hand's threads are stopped. Afterwards the hand holds no body and no tree. Impulses that no step
	/// has taken yet are lost.
	void remove(BulletDecoupledSource& hand);
	/// Releases a body; call it before the body is removed from the world, at any time, also in a callback of a step. Impulses that the
	/// body has not received yet are lost.
	void forget(const btCollisionObject* body);

	/// The game calls these two around its step. `seconds` is the time that Bullet will simulate until afterStep(), in one or several
	/// steps. In a world with a fixed step it is the length of the steps in the frame, and 0 in a frame without a step. Unless `seconds` is
	/// above 0, both do nothing, and impulses of the hands wait for the next step. When a game is paused, its contacts fade as in a world
	/// that stalls.
	void beforeStep(double seconds);
	void afterStep();
	/// Takes one step of `seconds` with beforeStep() and afterStep(); does nothing unless `seconds` is above 0.
	void step(double seconds);
	/// Shows the hands the present world before its first step, which will follow after `seconds` (above 0). Otherwise a body that lies on
	/// a tool falls until the first step is done.
	void show(double seconds);

	/// Sum of the impulses that bodies have received from a hand [N s].
	ist::Vec3 appliedImpulse(const BulletDecoupledSource& hand) const;
	/// Number of bodies that were near a tool but found no free slot, summed over the steps.
	std::uint64_t crowded() const { return m_crowded; }
	/// Bodies near the tools that the hands did not feel in full after the last step, in the order of the hands.
	const std::vector<BulletUnfeltBody>& unfelt() const { return m_unfelt; }
	/// A text with one line for each of these bodies, and one for each part of a tool that feels nothing. `names` is as for
	/// btISTSceneReport. This function allocates; call it between steps.
	std::string unfeltReport(const btISTSceneReport::Names& names = {}) const;

private:
	/// A part of a body as it was when the body entered its slot.
	struct PartKey
	{
		const btCollisionShape* shape;
		int type;
		const ist::InnerSphereTree* tree;
	};
	struct Tenant
	{
		btCollisionObject* object = nullptr;
		std::vector<PartKey> parts;
		/// Change of velocity of a link by the last push, over the change that its bound allows (BulletLinks).
		double response = 1;
	};
	struct Hand
	{
		BulletDecoupledSource* source;
		std::unique_ptr<BulletToolContacts> finder;
		std::vector<Tenant> tenants;  ///< one for each slot
		ist::Vec3 applied;
		std::uint64_t tick = 0;
		std::uint64_t droppedContacts = 0;  ///< WorldSnapshot::droppedContacts
		bool moving = false;                ///< whether the hand has posted since the last step
	};
	/// A link that one or several hands have pushed.
	struct PushedLink
	{
		const btMultiBodyLinkCollider* link;
		ist::Vec3 impulse;      ///< sum over the hands [N s]
		double pushed = 0;      ///< sum of the lengths of the impulses [N s]
		ist::Vec3 before;       ///< velocity [m/s]
		ist::Vec3 inverseMass;  ///< bound of the response (BulletLinks) [1/kg]
		ist::Vec3 fall;         ///< change of velocity by gravity [m/s]
	};
	struct Pushed
	{
		btRigidBody* body;
		ist::Twist before;
		ist::Wrench impulse;
		double share = 0;  ///< share of time before the impulse was given, times the length of the impulse
	};

	bool begin(double seconds);
	void push(Hand& hand, int slot);
	void pushLink(const btMultiBodyLinkCollider& link, const ist::Wrench& impulse);
	double responseOf(const PushedLink& pushed, const ist::Vec3& velocity, double before) const;
	void describeLink(Hand& hand, int slot, const btMultiBodyLinkCollider& link);
	void publish(std::uint64_t stamp);
	void putBack();
	void chooseBodies(Hand& hand);
	void admit(Hand& hand, btCollisionObject& object);
	void listPairs(Hand& hand, WorldSnapshot& out);
	void listPairs(Hand& hand, int slot, WorldSnapshot& out);
	void setConstants(const Hand& hand, const btCollisionObject& body, MirroredPair& out, const ShapeModel& model) const;
	static bool isFiniteBody(const btCollisionObject& object);
	bool isNear(const Hand& hand, const ToolPart& part, const btVector3& low, const btVector3& high, double share) const;
	bool isNear(const Hand& hand, const btCollisionObject& object, double share) const;
	void report(const Hand& hand, const btCollisionObject& body, BulletUnfeltBody::Reason reason, bool inPart);
	void showContacts(Hand& hand, WorldSnapshot& out, std::uint64_t stamp);
	void showStockContacts(Hand& hand, WorldSnapshot& out);
	void findToolContacts(Hand& hand, WorldSnapshot& out);
	bool isAsAdmitted(const Tenant& tenant) const;
	void describe(Hand& hand, int slot);
	bool watches(const Hand& hand, const btCollisionObject& body, bool was) const;
	ist::Pose begunAt(const btCollisionObject* body) const;

	btDynamicsWorld& m_world;
	btISTRegistration& m_registration;
	const btISTPairRule& m_rule;
	std::vector<Hand> m_hands;
	std::vector<Pushed> m_pushed;
	std::vector<PushedLink> m_pushedLinks;
	std::unique_ptr<BulletLinks> m_links;
	bool m_stepped = false;  ///< whether the world has taken a step, after which multibodies know their response
	std::vector<BulletUnfeltBody> m_unfelt;
	double m_seconds = 0;        ///< length of the step that has begun [s]; 0: none
	double m_sinceContacts = 0;  ///< time that the bodies moved since their contacts were found [s]
	std::uint64_t m_crowded = 0;
};
}  // namespace devicebridge
