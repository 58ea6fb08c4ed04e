// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "DeviceBridge/Bullet/BulletHand.h"
#include "demos/scenes/Grasp/GraspBody.h"
#include "demos/scenes/Grasp/GraspMotion.h"

#include <array>
#include <string>
#include <vector>

namespace scenes
{
/// Which part of the wrench on its hand the arm of a scripted hand feels.
enum class Felt
{
	Nothing,        ///< nothing, like a tracked hand: the hand follows the script
	Force,          ///< three degrees of freedom: the hand yields to the force, and rotates as the script says
	ForceAndTorque  ///< six degrees of freedom: the hand yields to both
};

struct CarryOptions
{
	int hands = 2;  ///< 1: the right hand grips the beam in its middle; 2: both hands grip it near its ends
	Felt felt = Felt::ForceAndTorque;
	double friction = 0.5;    ///< friction coefficient of the pair of skin and beam
	double step = 1.0 / 500;  ///< [s]
	double apart = 0.17;      ///< distance from the middle of the beam to each of two hands [m]
	devicebridge::BulletHandSettings hand;
	int64_t handSpheres = 150, objectSpheres = 1500;
	std::string cache;  ///< folder for trees
	ist::Progress progress;
};

/// The arm behind a hand: mass and inertia that a spring and a critical damper pull to the scripted pose, and that the felt wrench moves.
/// Its numbers are assumptions: the order of magnitude of a relaxed adult.
struct OperatorArm
{
	static constexpr double kMass = 1.5, kInertia = 0.01;             ///< [kg, kg m^2]
	static constexpr double kStiffness = 300, kAngularStiffness = 3;  ///< [N/m, N m/rad]

	ist::Pose X_WR;  ///< pose of the wrist
	ist::Twist twist;

	/// Makes one step. `felt` is the wrench on the wrist, about its origin, World. `mass` and `inertia` are added to the arm's own. They
	/// slow the step down, because the springs that pull at the hand are taken at its beginning and could make it oscillate.
	void step(const ist::Pose& wanted, const ist::Twist& moving, const ist::Wrench& felt, double mass, double inertia, double h) noexcept;
};

/// A beam on a table with a nut and a ring standing on it. One hand or two lift it by a script, carry it aside, turn it and put it down.
class CarryScene
{
public:
	enum Object
	{
		kBeam,
		kNut,
		kRing,
		kObjects
	};
	struct Hand
	{
		GraspMotion motion;  ///< motion in the beam's frame
		std::unique_ptr<devicebridge::BulletHand> hand;
		OperatorArm arm;
		ist::Wrench felt;  ///< sum of the wrenches of the parts' couplings, about the wrist, World
	};

	/// Offline: takes seconds for each tree that the cache lacks.
	static ist::Result<std::unique_ptr<CarryScene>> make(const CarryOptions& options);
	~CarryScene();

	/// Restarts the scene, with other hands.
	std::optional<ist::Error> start(int hands, Felt felt);
	void step();

	double time() const { return m_time; }
	double stepSize() const { return m_options.step; }
	Felt felt() const { return m_felt; }
	/// Scripted pose of the beam's mesh.
	static ist::Pose wantedBeam(double time);
	ist::Pose X_WM(Object object) const { return m_bodies[object]->X_WM(); }
	const btRigidBody& body(Object object) const { return m_bodies[object]->body(); }
	const std::vector<Hand>& hands() const { return m_hands; }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	double mass() const;

	static constexpr double kLength = 0.46, kHeight = 0.03, kWidth = 0.055;  ///< size of the beam along x, y, z [m]

private:
	CarryScene() = default;
	void leave();
	std::optional<ist::Error> addHand(bool left, double gripX);

	CarryOptions m_options;
	Felt m_felt = Felt::Nothing;
	std::array<GraspSolid, kObjects> m_solids;
	std::array<std::shared_ptr<const devicebridge::HandModel>, 2> m_models;  // right and left hand
	std::unique_ptr<btISTWorld> m_world;
	std::unique_ptr<btCollisionShape> m_groundShape;
	std::unique_ptr<btRigidBody> m_ground;
	std::array<std::unique_ptr<GraspBody>, kObjects> m_bodies;
	std::vector<Hand> m_hands;
	std::unique_ptr<btEnergyAudit> m_audit;
	double m_time = 0;
};
}  // namespace scenes
