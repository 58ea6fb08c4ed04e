// SPDX-License-Identifier: Zlib
#include "demos/browser/base/WorldDemo.h"

#include "BulletHapticForce/World/btISTSceneReport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/browser/base/SceneSaver.h"

#include <cmath>
#include <cstdio>
#include <limits>

using namespace ist;

namespace browser
{
namespace
{
constexpr size_t kMostSamples = 600;
constexpr double kBallPerView = 0.03;  // radius of the ball of a hand that feels, over the distance of the camera
constexpr long long kBallSpheres = 500;
constexpr double kBallFrequency = 100;  // root of the coupling's stiffness over the mass of this ball [rad/s]

void append(std::vector<float>& line, double value)
{
	if (line.size() == kMostSamples) line.erase(line.begin());
	line.push_back(float(value));
}

void shiftBy(DrawList& list, const Vec3& shift)
{
	for (auto& s : list.surfaces) s.X_WM.translation += shift;
	for (auto& s : list.spheres) s.X_WM.translation += shift;
	for (auto& d : list.discs) d.center += shift;
	for (auto& a : list.arrows) a.from += shift, a.to += shift;
	for (auto& l : list.lines) l.from += shift, l.to += shift;
	for (auto& t : list.texts) t.at += shift;
}

void enlarge(DrawList& list, double zoom)
{
	for (auto& s : list.surfaces) s.X_WM.translation *= zoom, s.scale *= zoom;
	for (auto& s : list.spheres) s.X_WM.translation *= zoom, s.scale *= zoom;
	for (auto& d : list.discs) d.center *= zoom, d.radius *= zoom, d.thickness *= zoom;
	for (auto& a : list.arrows) a.from *= zoom, a.to *= zoom, a.width *= zoom;
	for (auto& l : list.lines) l.from *= zoom, l.to *= zoom;
	for (auto& t : list.texts) t.at *= zoom;
}

template <class T> void take(std::vector<T>& to, std::vector<T>& from) { to.insert(to.end(), from.begin(), from.end()); }
}  // namespace

DemoWorld& WorldDemo::addWorld(const Vec3& gravity, const Vec3& shift, const std::string& title, double zoom)
{
	m_parts.push_back(
		{std::make_unique<DemoWorld>(m_stock ? scenes::Response::Stock : scenes::Response::Volumetric, gravity), shift, title, zoom});
	return *m_parts.back().world;
}

std::optional<Error> WorldDemo::restart()
{
	m_hand.release();
	m_forces.reset();
	m_ball = nullptr;
	leave();
	m_parts.clear();
	m_time = m_nextSample = 0;
	for (Curve* curve : {&m_force, &m_pairs, &m_energy, &m_cost}) curve->values.clear(), curve->errors.clear();
	if (auto error = build()) return error;
	for (Part& part : m_parts)
	{
		if (part.world->error()) return part.world->error();
		applyContactCache(part);
	}
	if (m_awake) keepAwake(true);
	return std::nullopt;
}

void WorldDemo::step(double seconds)
{
	beforeStep(seconds);
	m_hand.pull(seconds);
	if (m_forces) m_forces->beforeStep(seconds);
	for (Part& part : m_parts) part.world->step(seconds / std::sqrt(part.zoom));
	if (m_forces) m_forces->afterStep();
	m_time += seconds;
	afterStep(seconds);
	if (m_time < m_nextSample) return;
	m_nextSample += 1.0 / 60;
	sample();
}

std::optional<Error> WorldDemo::feel(devicebridge::Device& device, btRigidBody& tool, double scale)
{
	m_hand.release();
	m_forces.reset();
	Result<std::unique_ptr<ForceHand>> made = ForceHand::make(device, *m_parts.front().world, tool, scale);
	if (!made) return made.error();
	m_forces = std::move(made).value();
	return std::nullopt;
}

std::optional<Error> WorldDemo::feelWith(devicebridge::Device& device, double scale)
{
	if (m_parts.empty()) return Error{"the demo has not begun"};
	stopFeeling();
	const double radius = kBallPerView * viewpoint().distance / m_parts.front().zoom;
	SolidPtr ball;
	if (auto refused = makeSolid(ball, "ball of the hand", makeSphereMesh(radius, 3), kBallSpheres, {})) return refused;
	Vec3 top{0, -std::numeric_limits<double>::infinity(), 0};
	for (const DemoWorld::Body& b : world().bodies())
		for (const Vec3& vertex : b.visibleMesh().vertices)
			if (const Vec3 p = b.X_WP() * vertex; p.y > top.y) top = p;
	if (!isFinite(top)) top = viewpoint().target;
	// Light, so that the coupling of this device moves it at once.
	devicebridge::DeviceInfo limits = device.info();
	scaleLimits(limits, scale);
	BodySetup setup;
	setup.name = ball->name;
	setup.mass = devicebridge::gainsForDevice(limits, 1e-3).stiffness / (kBallFrequency * kBallFrequency);
	setup.colour = {0.85f, 0.65f, 0.2f};
	setup.X_WM.translation = top + Vec3{0, 1.5 * radius, 0};
	m_ball = world().add(ball, std::move(setup));
	if (!m_ball) return world().error();
	auto refused = feel(device, *m_ball, scale);
	if (refused) stopFeeling();
	return refused;
}

void WorldDemo::stopFeeling()
{
	m_forces.reset();
	if (m_ball) world().remove(m_ball);
	m_ball = nullptr;
}

std::string WorldDemo::felt() const
{
	if (!m_forces) return {};
	const std::string bodies = std::to_string(m_forces->contacts());
	return m_forces->state() + ", touches " + bodies + (bodies == "1" ? " body, " : " bodies, ") + formatForce(norm(m_forces->force()));
}

void WorldDemo::sample()
{
	double force = 0, error = 0, pairs = 0, energy = 0, cost = 0;
	for (const Part& part : m_parts)
	{
		const ContactSums sums = part.world->contactSums();
		force += sums.force;
		error = std::hypot(error, sums.forceError);
		pairs += double(sums.pairs);
		energy += part.world->mechanicalEnergy();
		cost += part.world->stepMicroseconds();
	}
	append(m_force.values, force);
	append(m_force.errors, error);
	append(m_pairs.values, pairs);
	append(m_energy.values, energy);
	append(m_cost.values, cost);
}

void WorldDemo::draw(const DrawChoice& choice, DrawList& list)
{
	list.wireframe = choice.wireframe;
	list.shadows = choice.shadows;
	list.ground = choice.ground;
	std::set<int> answering;
	for (Part& part : m_parts)
	{
		m_one.clear();
		// Weights grow with the third power of lengths, so forces are scaled by it.
		m_view.draw(*part.world, choice, arrowForce() / (part.zoom * part.zoom * part.zoom), arrowLength() / part.zoom, m_one);
		answering.insert(m_view.answering().begin(), m_view.answering().end());
		if (part.zoom != 1) enlarge(m_one, part.zoom);
		shiftBy(m_one, part.shift);
		take(list.surfaces, m_one.surfaces);
		take(list.spheres, m_one.spheres);
		take(list.discs, m_one.discs);
		take(list.arrows, m_one.arrows);
		take(list.lines, m_one.lines);
		take(list.texts, m_one.texts);
		for (const DrawnKey& key : m_one.keys) list.addKey(key.colour, key.text);
		const Viewpoint view = viewpoint();
		if (!part.title.empty())
			list.texts.push_back({part.shift + Vec3{0, 2 * view.target.y + 0.09 * view.distance, 0}, part.title, {0.1f, 0.1f, 0.12f}});
	}
	if (m_hand.holds())
		list.lines.push_back({toVec3(m_hand.body()->getWorldTransform().getOrigin()), m_hand.target().translation, {0.1f, 0.1f, 0.8f}});
	decorate(choice, list);
	addSphereKeys(answering, list);
	list.ground = list.ground && choice.ground;
}

Result<std::vector<std::string>> WorldDemo::saveScene(const std::string& path)
{
	if (m_parts.empty()) return Error{"the demo has not begun"};
	Result<std::vector<std::string>> leftOut = browser::saveScene(*m_parts.front().world, sceneTool(), path);
	if (!leftOut || m_parts.size() < 2) return leftOut;
	std::vector<std::string> all = leftOut.value();
	all.push_back("the other " + std::to_string(m_parts.size() - 1) + " worlds of this demo");
	return all;
}

std::vector<Curve> WorldDemo::curves() const { return {m_force, m_pairs, m_energy, m_cost}; }

void WorldDemo::applyContactCache(Part& part) const
{
	btISTWorld* world = part.world->volumetric();
	if (!world) return;
	world->setContactCache({m_contactCache.on, m_contactCache.on ? m_contactCache.maxError : 0});
	world->setForceError(m_contactCache.forceError);
}

void WorldDemo::setContactCache(const ContactCacheChoice& contactCache)
{
	m_contactCache = contactCache;
	for (Part& part : m_parts) applyContactCache(part);
}

std::vector<DemoWorld*> WorldDemo::worlds() const
{
	std::vector<DemoWorld*> all;
	for (const Part& part : m_parts) all.push_back(part.world.get());
	return all;
}

std::string WorldDemo::nameOf(const btCollisionObject* object) const
{
	for (const Part& part : m_parts)
		for (const DemoWorld::Body& b : part.world->bodies())
			if (b.body.get() == object) return b.name;
	return "ground";
}

btISTSceneReport WorldDemo::sceneReport(const Part& part) const
{
	return btISTSceneReport::of(*part.world->volumetric(), [this](const btCollisionObject* object) { return nameOf(object); });
}

std::vector<std::string> WorldDemo::report() const
{
	std::vector<std::string> rows;
	char row[200];
	for (const Part& part : m_parts)
	{
		int awake = 0, asleep = 0;
		for (const DemoWorld::Body& b : part.world->bodies())
			if (!b.body->isStaticOrKinematicObject()) ++(b.body->isActive() ? awake : asleep);
		const ContactSums sums = part.world->contactSums();
		std::snprintf(row, sizeof row, "%s%s%d bodies move, %d sleep; step %.0f us, of it queries %.0f us", part.title.c_str(),
			part.title.empty() ? "" : ": ", awake, asleep, part.world->stepMicroseconds(), sums.queryMicroseconds);
		rows.push_back(row);
		if (!part.world->volumetric()) continue;
		for (std::string& line : sceneReport(part).lines()) rows.push_back(std::move(line));
	}
	return rows;
}

std::string WorldDemo::reportJson() const
{
	std::string all;
	for (const Part& part : m_parts)
		if (part.world->volumetric()) all += (all.empty() ? "[" : ",") + sceneReport(part).json();
	return all.empty() ? all : all + "]";
}

std::optional<double> WorldDemo::grab(const Vec3& from, const Vec3& direction)
{
	double nearest = -1;
	btRigidBody* met = nullptr;
	for (const Part& part : m_parts)
		for (const DemoWorld::Body& b : part.world->bodies())
		{
			// A tool that a device feels is not in the world.
			if (part.zoom != 1 || !b.body->isInWorld()) continue;
			const double t = rayMeetsMesh(b.visibleMesh(), b.X_WP(), from - part.shift, direction);
			if (t > 0 && (nearest < 0 || t < nearest)) nearest = t, met = b.body.get();
		}
	if (!met || met->isStaticOrKinematicObject()) return std::nullopt;
	m_hand.grab(met);
	return nearest;
}

bool WorldDemo::grabTool()
{
	if (m_hand.holds()) return true;
	// The tool is the last body that moves: demos add resting bodies first, and then those that come to them.
	for (const DemoWorld::Body& b : m_parts.front().world->bodies())
		if (!b.body->isStaticOrKinematicObject()) m_hand.grab(b.body.get());
	return m_hand.holds();
}

void WorldDemo::keepAwake(bool on)
{
	m_awake = on;
	for (Part& part : m_parts) part.world->keepAwake(on);
}
}  // namespace browser
