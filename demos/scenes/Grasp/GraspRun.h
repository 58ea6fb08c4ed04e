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
	std::string mesh;       ///< a file instead (loadGraspObject)
	double unit = 0;        ///< of that file [m]; 0: as loadGraspObject thinks right
	double friction = 0.5;  ///< of the pair
	bool left = false;
	double handLength = 0.189;  ///< [m]
	double step = 1.0 / 500;    ///< [s]
	double squeeze = GraspMotion().squeeze;
	devicebridge::BulletHandSettings hand;
	int64_t handSpheres = 150, objectSpheres = 1500;
	std::string cache;  ///< folder for trees
	ist::Progress progress;
};

/// A hand, a table and something to grasp, headless. Trees of one object and hand are made once; `start` begins anew.
class GraspScene
{
public:
	/// Offline: seconds for each tree that the cache lacks.
	static ist::Result<std::unique_ptr<GraspScene>> make(const GraspOptions& options);
	~GraspScene();

	/// To the beginning, with this friction.
	std::optional<ist::Error> start(double friction);
	/// One step; the hand where the motion has it, or where `hand` is.
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
	/// Of the object's mesh, as GraspObject has it, in World.
	ist::Pose X_WM() const { return m_body->X_WM(); }
	const btEnergyBalance& energy() const { return m_audit->total(); }
	/// The contacts between the hand and the object in the last step, for GraspQuality: one a patch, in the frame of the object's centre of
	/// mass.
	std::vector<devicebridge::GraspContact> graspContacts() const;
	/// Of the object, as GraspObject has it.
	std::unique_ptr<devicebridge::HeatMap> makeHeatMap() const { return devicebridge::makeHeatMap(*m_model, m_object.mesh); }
	/// The last step; the force that was added [N].
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
	double time = 0, height = 0;  ///< of the object's centre of mass over where it stood [s, m]
	double force = 0;             ///< sum of the magnitudes on the hand's parts [N]
	double strongest = 0;         ///< of them [N]
	double slip = 0;              ///< of the object in the palm since it was lifted [m]
	int parts = 0;                ///< that touch
	double pairs = 0;
};

struct GraspOutcome
{
	std::string object;
	double friction = 0;
	bool held = false;         ///< off the table from the end of lifting to the end of shaking
	bool putDown = false;      ///< at rest on the table in the end, upright or not
	double slip = 0;           ///< largest way of the centre of mass in the palm's frame between lifting and the end of shaking [m]
	double slipAngle = 0;      ///< and turn [rad]
	double peakForce = 0;      ///< on one part, at any time [N]
	double couplingForce = 0;  ///< largest that a coupling exerted [N]
	double holdingForce = 0;   ///< mean of the sum over the parts while held still, before the shaking [N]
	int parts = 0;             ///< in contact then
	devicebridge::GraspQuality quality;  ///< then
	btEnergyBalance energy;
	std::string complaints;            ///< of the hand's samples
	std::vector<GraspSample> samples;  ///< 100 a second
};

/// The whole motion. `eachStep` after every step.
ist::Result<GraspOutcome> runGrasp(GraspScene& scene, double friction, const std::function<void()>& eachStep = {});
}  // namespace scenes
