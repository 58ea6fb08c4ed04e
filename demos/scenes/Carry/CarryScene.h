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
/// What the arm of a scripted hand is told of the forces on its hand.
enum class Felt
{
	Nothing,        ///< as of a tracked hand: it goes where the script says
	Force,          ///< three degrees of freedom: it yields to the force, and turns as the script says
	ForceAndTorque  ///< six: it yields to both
};

struct CarryOptions
{
	int hands = 2;  ///< 1: the right one grips the beam in its middle; 2: both grip it near its ends
	Felt felt = Felt::ForceAndTorque;
	double friction = 0.5;    ///< of the pair of skin and beam
	double step = 1.0 / 500;  ///< [s]
	double apart = 0.17;      ///< from the middle of the beam to each of two hands [m]
	devicebridge::BulletHandSettings hand;
	int64_t handSpheres = 150, objectSpheres = 1500;
	std::string cache;  ///< folder for trees
	ist::Progress progress;
};

/// The arm behind a hand: mass and inertia pulled to where the script has them by a spring and a critical damper, and by what the hand
/// feels. Its numbers are assumed: those of a relaxed adult, to an order.
struct OperatorArm
{
	static constexpr double kMass = 1.5, kInertia = 0.01;             ///< [kg, kg m^2]
	static constexpr double kStiffness = 300, kAngularStiffness = 3;  ///< [N/m, N m/rad]

	ist::Pose X_WR;  ///< of the wrist
	ist::Twist twist;

	/// `felt`: on the wrist, about its origin, World. `mass` and `inertia` more than the arm's own: what a step must be slowed by, so that
	/// the springs that pull at the hand, taken at its beginning, cannot make it swing.
	void step(const ist::Pose& wanted, const ist::Twist& moving, const ist::Wrench& felt, double mass, double inertia, double h) noexcept;
};

/// A beam on a table, a nut and a ring standing on it, and one hand or two that lift it by a script, carry it aside, turn it and put it
/// down.
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
		GraspMotion motion;  ///< in the beam's frame
		std::unique_ptr<devicebridge::BulletHand> hand;
		OperatorArm arm;
		ist::Wrench felt;  ///< sum of what the parts' couplings give back, about the wrist, World
	};

	/// Offline: seconds for each tree that the cache lacks.
	static ist::Result<std::unique_ptr<CarryScene>> make(const CarryOptions& options);
	~CarryScene();

	/// To the beginning, with other hands.
	std::optional<ist::Error> start(int hands, Felt felt);
	void step();

	double time() const { return m_time; }
	double stepSize() const { return m_options.step; }
	Felt felt() const { return m_felt; }
	/// Where the script has the beam's mesh.
	static ist::Pose wantedBeam(double time);
	ist::Pose X_WM(Object object) const { return m_bodies[object]->X_WM(); }
	const btRigidBody& body(Object object) const { return m_bodies[object]->body(); }
	const std::vector<Hand>& hands() const { return m_hands; }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	double mass() const;

	static constexpr double kLength = 0.46, kHeight = 0.03, kWidth = 0.055;  ///< of the beam, along x, y, z [m]

private:
	CarryScene() = default;
	void leave();
	std::optional<ist::Error> addHand(bool left, double gripX);

	CarryOptions m_options;
	Felt m_felt = Felt::Nothing;
	std::array<GraspSolid, kObjects> m_solids;
	std::array<std::shared_ptr<const devicebridge::HandModel>, 2> m_models;  // right, left
	std::unique_ptr<btISTWorld> m_world;
	std::unique_ptr<btCollisionShape> m_groundShape;
	std::unique_ptr<btRigidBody> m_ground;
	std::array<std::unique_ptr<GraspBody>, kObjects> m_bodies;
	std::vector<Hand> m_hands;
	std::unique_ptr<btEnergyAudit> m_audit;
	double m_time = 0;
};
}  // namespace scenes
