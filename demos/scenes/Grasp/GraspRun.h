// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "DeviceBridge/Bullet/BulletHeatMap.h"
#include "DeviceBridge/Hand/Grasp/GraspQuality.h"
#include "demos/scenes/Grasp/GraspBody.h"
#include "demos/scenes/Grasp/GraspMotion.h"
#include "demos/scenes/Grasp/GraspObjects.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace scenes
{
struct GraspOptions
{
	std::string object = "mug";
	std::string mesh;       ///< mesh file that replaces the object (loadGraspObject)
	GraspFile file;         ///< how that file is read
	double friction = 0.5;  ///< friction coefficient of the pair
	bool left = false;
	double handLength = 0.189;  ///< [m]
	double step = 1.0 / 500;    ///< [s]
	double squeeze = GraspMotion().squeeze;
	devicebridge::BulletHandSettings hand;
	int64_t handSpheres = 150, objectSpheres = 1500;
	std::string cache;  ///< folder for trees
	ist::Progress progress;
};

/// A hand, a table and an object to grasp, without graphics. The trees of one object and hand are made once; `start` restarts the scene.
class GraspScene
{
public:
	/// Offline: takes seconds for each tree that the cache lacks.
	static ist::Result<std::unique_ptr<GraspScene>> make(const GraspOptions& options);
	~GraspScene();

	/// Restarts the scene, with this friction coefficient.
	std::optional<ist::Error> start(double friction);
	/// Makes one step. The hand follows the motion, or is at `hand`.
	void step();
	void step(const devicebridge::HandState& hand);

	double time() const { return m_time; }
	double stepSize() const { return m_options.step; }
	const GraspObject& object() const { return m_object; }
	const GraspMotion& motion() const { return m_motion; }
	const std::shared_ptr<const ist::InnerSphereTree>& objectTree() const { return m_solid.tree; }
	devicebridge::BulletHand& hand() { return *m_hand; }
	btISTWorld& world() { return *m_world; }
	btRigidBody& body() { return m_body->body(); }
	/// Pose of the object's mesh (that of GraspObject) in World.
	ist::Pose X_WM() const { return m_body->X_WM(); }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	/// Contacts between hand and object in the last step, for GraspQuality: one for each patch, in the frame of the object's centre of
	/// mass.
	std::vector<devicebridge::GraspContact> graspContacts() const;
	/// Makes a heat map of the object's mesh (that of GraspObject).
	std::unique_ptr<devicebridge::HeatMap> makeHeatMap() const { return devicebridge::makeHeatMap(*m_model, m_object.mesh); }
	/// Adds the touches of the last step. Returns the force that was added [N].
	double addTouches(devicebridge::HeatMap& map) const;
	void addTouches(devicebridge::BulletHeatMapRounds& rounds) const;

private:
	GraspScene() = default;
	void leave();

	GraspOptions m_options;
	GraspObject m_object;
	GraspMotion m_motion;
	GraspSolid m_solid;
	std::shared_ptr<const devicebridge::HandModel> m_model;
	std::unique_ptr<btISTWorld> m_world;
	std::unique_ptr<btCollisionShape> m_groundShape;
	std::unique_ptr<btRigidBody> m_ground;
	std::unique_ptr<GraspBody> m_body;
	std::unique_ptr<devicebridge::BulletHand> m_hand;
	std::unique_ptr<btEnergyAudit> m_audit;
	double m_time = 0;
};

/// One moment of a grasp.
struct GraspSample
{
	double time = 0, height = 0;  ///< time [s], and height of the object's centre of mass above its start [m]
	double force = 0;             ///< sum of the magnitudes of the forces on the hand's parts [N]
	double strongest = 0;         ///< largest of these forces on a bone [N]
	double palm = 0;              ///< force on the palm [N]
	double slip = 0;              ///< path of the object in the palm since it was lifted [m]
	int parts = 0;                ///< number of parts that touch
	double pairs = 0;
};

struct GraspOutcome
{
	static constexpr double kOffTable = 0.02;  ///< height of the object's centre of mass above its start when it is lifted [m]
	std::string object;
	double friction = 0;
	bool held = false;         ///< true: off the table from the end of lifting to the end of shaking
	bool putDown = false;      ///< true: at rest on the table at the end, upright or not
	double slip = 0;           ///< largest path of the centre of mass in the palm's frame between lifting and the end of shaking [m]
	double slipAngle = 0;      ///< largest rotation in that time [rad]
	double peakForce = 0;      ///< largest force on one bone at any time [N]
	double palmForce = 0;      ///< largest force on the palm at any time [N]
	double couplingForce = 0;  ///< largest force that the coupling of a bone exerted [N]
	double gripForce = 0;      ///< largest sum of the forces on the parts from closing to the end of shaking, or until it was lost [N]
	double lostAt = 0;         ///< time at which it was lost: near the table, or without a touch [s]; 0: held
	double lostHeight = 0;     ///< height above its start at that time [m]
	bool touched = false;      ///< true: a part touched it after closing
	double holdingForce = 0;   ///< sum of the forces on the parts, averaged over the rest before shaking [N]
	int parts = 0;             ///< number of parts in contact during that rest
	devicebridge::GraspQuality quality;  ///< grasp quality during that rest
	btEnergyBalance energy;
	std::string complaints;            ///< complaints about the hand's samples
	std::vector<GraspSample> samples;  ///< 100 samples a second
};

/// Runs the whole motion. `eachStep` is called after every step.
ist::Result<GraspOutcome> runGrasp(GraspScene& scene, double friction, const std::function<void()>& eachStep = {});
}  // namespace scenes
