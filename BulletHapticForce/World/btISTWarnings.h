// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h"

#include "BulletDynamics/Dynamics/btActionInterface.h"

#include <cstdint>
#include <functional>

class btCollisionObject;
class btDiscreteDynamicsWorld;

/// What may be wrong with a scene, although it runs.
enum class btISTWarning
{
	Deep,           ///< a contact has been deeper than a tenth of the thinner body (btISTContact::isDeep) for 0.1 s or longer
	PassedThrough,  ///< the force of a contact has reversed: one body was pushed, or fell, through the other
	TooFast,        ///< a pair was too fast for the step, so that its first touch may have been missed
	NoBox,          ///< the box of a shape with a tree is empty or not finite, so that the broad phase finds no pair of it
	NoInertia,      ///< a body with a tree can be moved, but not turned, although its angular factor allows it
	Scaled,         ///< a shape has another scaling than when its tree was attached, so that the tree is not used
	IgnoredCcd      ///< a body has Bullet's flags for continuous collision detection, and nothing here reads them
};
constexpr int kWarningKinds = 7;

/// Counts what may be wrong in a world, and says it once per kind. btISTWorld owns one, and Bullet calls it at the end of each step, when
/// the bodies have moved. Its cost: O(contacts) in a step, and O(bodies) in one step of 64. No allocation.
class btISTWarnings : public btActionInterface
{
public:
	struct Record
	{
		uint64_t count = 0;                        ///< contacts, summed over all steps; of the last four kinds: bodies, at the last look
		const btCollisionObject* bodyA = nullptr;  ///< of the worst contact, or the last body; compare the address only
		const btCollisionObject* bodyB = nullptr;  ///< null where a body is counted
		double k = 0;                              ///< stiffness of this contact [Pa/m]
		double depth = 0;                          ///< its mean depth [m]
		double share = 0;                          ///< its depth as a share of the thinner body's thickness
	};
	/// Gets a line without a line break. Called after a step of btISTWorld::step; in a game's own stepSimulation at its end, when all
	/// bodies have moved. The text is valid during the call.
	using Log = std::function<void(const char* line)>;

	explicit btISTWarnings(btISTRegistration& registration) : m_registration(registration) {}

	const Record& operator[](btISTWarning kind) const { return m_records[int(kind)]; }
	/// Rule of the stiffness of the worst contact.
	btISTStiffnessRule ruleOf(btISTWarning kind) const { return m_rules[int(kind)]; }
	/// Sum of all counts.
	uint64_t count() const;
	/// Without a log, the lines are written to stderr.
	void setLog(Log log) { m_log = std::move(log); }
	/// While it waits, lines are kept until `write`.
	void wait(bool waits) { m_waits = waits; }
	/// Writes the line of each kind that was found since, at most once.
	void write();

	/// Name of a kind, as the report writes it.
	static const char* nameOf(btISTWarning kind);
	/// What to do about it, in one sentence. Of the kinds that concern a contact, `rule` is the rule of its stiffness.
	static const char* advice(btISTWarning kind, btISTStiffnessRule rule);

	void updateAction(btCollisionWorld* world, btScalar step) override;
	void debugDraw(btIDebugDraw*) override {}

private:
	void lookAtContacts(double step);
	void lookAtBodies(const btCollisionWorld& world);
	void note(btISTWarning kind, const btISTContact& contact);
	void note(btISTWarning kind, const btCollisionObject& body);

	btISTRegistration& m_registration;
	Record m_records[kWarningKinds];
	btISTStiffnessRule m_rules[kWarningKinds] = {};  // of the worst contact
	int m_places[kWarningKinds][2] = {};             // places of its bodies in the world
	bool m_written[kWarningKinds] = {};
	bool m_waits = false;
	unsigned m_steps = 0;
	Log m_log;
};
