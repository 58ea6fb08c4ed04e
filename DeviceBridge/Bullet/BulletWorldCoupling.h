// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <vector>

#include "BulletHapticForce/World/btISTWorld.h"
#include "DeviceBridge/Bullet/BulletDecoupledSource.h"

namespace devicebridge
{
/// The world's half of decoupled mode: around each step of a Bullet world, takes what the hands have given to its bodies and puts it on
/// them, and shows the hands the bodies near their tools. All in the thread that owns the world, at any rate; never waits.
///
/// Impulses enter as a force over the whole step, so that the implicit solver weighs them against all that holds the body: an impulse
/// that pressed a light body on a table for 0.2 s does not throw it. And since Bullet moves bodies by the velocity at the end of a
/// step, as if the whole impulse had come at its beginning, the body is put back by the share of time for which it had not.
///
/// What the hand feels: bodies whose own shape has a tree, and static planes; where pairs are watched (btISTPairFilter), those that are
/// watched with the tool, and in a watched region those that can meet the tool there, as the boxes of both stand after each step. Not felt:
/// the children of compounds, and shapes without a tree. A body whose shape, or the tree of it, is another than before is let go and felt
/// anew. A contact without a tree is known to the hand's copies only by what it did in the last step; a joint, and another hand on the same
/// body, by nothing but where the body is after each step: between two steps the hand feels the body without it.
class BulletWorldCoupling
{
public:
	explicit BulletWorldCoupling(btISTWorld& world) : BulletWorldCoupling(world.bullet(), world.registration(), world.materials()) {}
	/// All outlive this. `rule` decides the constants of tool and body as it does for bodies of the world.
	BulletWorldCoupling(btDynamicsWorld& world, btISTRegistration& registration, const btISTPairRule& rule);
	~BulletWorldCoupling();

	/// Between steps. A hand that was added lives as long as this takes steps, or is removed first. One that was in another coupling lets
	/// go of the bodies of that.
	void add(BulletDecoupledSource& hand);
	/// While the hand's threads are stopped. It holds no body and no tree any more; what it gave and no step has taken is lost.
	void remove(BulletDecoupledSource& hand);
	/// Before a body is removed from the world, at any time, in a callback of a step too: what hands gave it and it has not got yet is
	/// lost.
	void forget(const btCollisionObject* body);

	/// What the game calls. `seconds`: what Bullet will simulate until afterStep(), in one step or several: of a world with a fixed step
	/// not the length of the frame, but that of the steps in it, 0 in a frame without one. Unless it is above 0, neither of the two does
	/// anything, and what hands give waits for the next step. A game that is paused fades out of its hands as a world that stalls does.
	void beforeStep(double seconds);
	void afterStep();
	/// All three: one step of so many seconds; none unless that is above 0.
	void step(double seconds);
	/// Shows the hands the world as it is, before the first step, which will come in so many seconds (above 0). Otherwise a body that lies
	/// on a tool falls until the first step is done.
	void show(double seconds);

	/// Given to bodies on behalf of a hand so far [N s].
	ist::Vec3 appliedImpulse(const BulletDecoupledSource& hand) const;
	/// Bodies that were near a tool and found no slot, counted in each step.
	std::uint64_t crowded() const { return m_crowded; }

private:
	struct Hand
	{
		BulletDecoupledSource* source;
		std::unique_ptr<BulletToolContacts> finder;
		btCollisionObject* bodies[kMirroredBodies] = {};
		ist::Vec3 applied;
		std::uint64_t tick = 0;
		bool moving = false;  ///< it has posted since the last step
	};
	struct Pushed
	{
		btRigidBody* body;
		ist::Twist before;
		ist::Wrench impulse;
		double share = 0;  ///< times the length of the impulse
	};

	bool begin(double seconds);
	void push(Hand& hand, int slot);
	void publish(std::uint64_t stamp);
	void putBack();
	void chooseBodies(Hand& hand);
	void admit(Hand& hand, btCollisionObject& object, const ist::Vec3& center, double reach);
	void showContacts(Hand& hand, WorldSnapshot& out, std::uint64_t stamp);
	void showStockContacts(Hand& hand, WorldSnapshot& out);
	void findToolContacts(Hand& hand, WorldSnapshot& out);
	bool isAsAdmitted(const Hand& hand, int slot) const;
	void describe(Hand& hand, int slot);
	bool watches(const Hand& hand, const btCollisionObject& body, bool was) const;
	ist::Pose begunAt(const btCollisionObject* body) const;

	btDynamicsWorld& m_world;
	btISTRegistration& m_registration;
	const btISTPairRule& m_rule;
	std::vector<Hand> m_hands;
	std::vector<Pushed> m_pushed;
	double m_seconds = 0;  ///< of the step that has begun; 0: none
	std::uint64_t m_crowded = 0;
};
}  // namespace devicebridge
