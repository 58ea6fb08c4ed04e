// SPDX-License-Identifier: Zlib
#include "demos/browser/base/HandDemo.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletHeatMap.h"
#include "demos/scenes/Grasp/GraspMotion.h"
#include "demos/scenes/Grasp/GraspObjects.h"

using namespace ist;
using namespace devicebridge;
using scenes::GraspMotion;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kMapEvery = 0.1;
constexpr long long kObjectSpheres = 1500;
const Vec3 kFingerSide{-0.12, 0, -0.05}, kThumbSide{-0.21, 0, 0.01};

/// A hand of sixteen parts closes on a mug, lifts it, turns it and shakes it at 2 Hz. Beside it, the map of its touches is shown from
/// both sides, with one colour per finger.
class Grasp : public HandDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<scenes::GraspObject> object = scenes::makeGraspObject("mug");
		if (!object) return object.error();
		m_object = std::move(object).value();
		if (auto error = makeSolid(m_mug, m_object.name, m_object.mesh, kObjectSpheres, options)) return error;
		if (auto error = prepareHand(m_motion.size, options)) return error;
		m_motion.gripX = m_object.gripX;
		m_motion.gripZ = m_object.gripZ;
		m_motion.gripHeight = m_object.gripHeight;
		m_motion.width = m_object.width;
		return std::nullopt;
	}
	double stepSize() const override { return 1.0 / 500; }
	/// At this time the mug is still in the air.
	double duration() const override { return GraspMotion::kRested; }
	Viewpoint viewpoint() const override { return {{-0.08, 0.115, 0}, 0.58, -2.5, 0.22}; }
	std::vector<Parameter> parameters() override
	{
		return {{"squeeze by", "m", &m_motion.squeeze, 0, 0.03, false, false}, {"friction", "", &m_friction, 0, 1, true, false}};
	}
	std::vector<Figure> figures() const override
	{
		const double weight = m_object.mass * kGravity;
		Vec3 carried;
		double strongest = 0;
		for (int i = 0; i < kHandParts; ++i)
		{
			const Vec3 force = world().contactForce(m_body, &parts().body(i));
			carried += force;
			strongest = std::max(strongest, norm(force));
		}
		const BulletHand::Touch touch = parts().touch(world().lastStep());
		return {{"weight that the hand carries", "N", carried.y, weight, 0.02 * weight},
			{"forces on the mug out of balance, sideways", "N", std::hypot(carried.x, carried.z), 0, 0.02 * weight},
			{"lifted", "mm", 1e3 * (toVec3(m_body->getWorldTransform().getOrigin()).y - m_mug->X_MP.translation.y), 1e3 * m_motion.lift, 4},
			{"parts in contact", "", double(touch.parts)}, {"strongest part", "N", strongest},
			{"force on the map, of that on the mug", "%", m_impulse > 0 ? 100 * mapImpulse() / m_impulse : 0, 100, 2}};
	}

protected:
	std::optional<Error> build() override
	{
		DemoWorld& w = addWorld();
		w.addPlane({0, 1, 0}, 0, 1);
		BodySetup mug;
		mug.name = m_object.name;
		mug.mass = m_object.mass;
		mug.friction = m_friction;
		mug.colour = {0.93f, 0.91f, 0.87f};
		m_body = w.add(m_mug, std::move(mug));
		if (!m_body) return std::nullopt;
		// With nothing set, what presses decides how stiff the skin is: softer fingers sink deep into the thin wall of a mug.
		BulletHandSettings settings;
		settings.skin = {};
		if (auto error = putHand(w, settings)) return error;
		m_map = makeHeatMap(model(), m_mug->mesh);
		m_mapModel.reset();
		m_nextMap = m_impulse = 0;
		return std::nullopt;
	}
	HandPosture motion(double at) const override { return m_motion.at(at); }
	void afterStep(double h) override
	{
		m_impulse += h * addTouches(*m_map, parts(), world().volumetric()->contacts(), *m_body, {}, h, h);
		if (time() < m_nextMap) return;
		m_nextMap += kMapEvery;
		m_mapModel.reset();
	}
	void decorate(const DrawChoice& choice, DrawList& list) override
	{
		list.gridCell = 0.02;
		drawHand(choice, list);
		if (!choice.surfaces) return;
		if (!m_mapModel) paintMap();
		const Mat3 turned{{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};
		list.surfaces.push_back({m_mapModel, {{}, kFingerSide + m_mug->X_MP.translation}, {1, 1, 1}});
		list.surfaces.push_back({m_mapModel, {turned, kThumbSide + m_mug->X_MP.translation}, {1, 1, 1}});
		list.texts.push_back({kFingerSide + Vec3{0, 0.1, 0}, "touched by fingers", {0.1f, 0.1f, 0.12f}});
		list.texts.push_back({kThumbSide + Vec3{0, 0.1, 0}, "by the thumb", {0.1f, 0.1f, 0.12f}});
	}
	double arrowForce() const override { return 10; }
	double arrowLength() const override { return 0.04; }

private:
	void paintMap()
	{
		std::vector<Colour> colours;
		for (const HeatMap::Vertex& v : m_map->vertices())
			colours.push_back(v.part < 0 ? Colour{0.93f, 0.91f, 0.87f} : fingerColour(m_map->partId(v.part)));
		m_mapModel = colouredModel(*m_mug->surface, m_mug->mesh, colours);
	}
	double mapImpulse() const
	{
		double sum = 0;
		for (const HeatMap::Vertex& v : m_map->vertices()) sum += v.impulse;
		return sum;
	}

	scenes::GraspObject m_object;
	GraspMotion m_motion;
	SolidPtr m_mug;
	std::shared_ptr<const SurfaceModel> m_mapModel;
	btRigidBody* m_body = nullptr;
	std::unique_ptr<HeatMap> m_map;
	double m_friction = 0.5, m_nextMap = 0, m_impulse = 0;
};
}  // namespace

std::unique_ptr<BrowsableDemo> makeGrasp() { return std::make_unique<Grasp>(); }
}  // namespace browser
