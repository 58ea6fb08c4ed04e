// SPDX-License-Identifier: Zlib
#include "demos/browser/base/HandDemo.h"

#include "BulletHapticForce/World/btEnergyAudit.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "demos/scenes/Bodies/ImplicitMesh.h"
#include "demos/scenes/Grasp/GraspObjects.h"
#include "demos/scenes/Truth/MeshDepth.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace ist;
using namespace devicebridge;

namespace browser
{
namespace
{
constexpr double kGravity = 9.81, kSize = 0.06;
constexpr int kBodies = 20, kColumns = 3;
constexpr long long kSpheres = 400;
const Vec3 kInside{0.1, 0.06, 0.1};  // size of the tray: half its length, its height, half its width [m]
constexpr double kBoard = 0.012;     // half the thickness of its boards [m]
constexpr double kLookEvery = 1.0 / 60;
constexpr double kMeanOver = 0.5;  // [s]
constexpr double kSinking = 0.12;  // speed of the hand as it lies down [m/s]

/// A jack: three crossed bars with knobs at their ends.
Mesh jackMesh(double size)
{
	const double knob = 0.15 * size, bar = 0.1 * size, reach = 0.5 * size - knob;
	const auto field = [=](const Vec3& p) {
		double deepest = -size;
		for (int a = 0; a < 3; ++a)
		{
			const double along = std::fabs(p[a]), beyond = std::max(along - reach, 0.0),
						 off = std::sqrt(std::max(squaredNorm(p) - along * along, 0.0));
			deepest = std::max({deepest, bar - std::hypot(off, beyond), knob - std::hypot(off, along - reach)});
		}
		return deepest;
	};
	const double half = 0.56 * size;
	return scenes::meshOfField(field, {{-half, -half, -half}, {half, half, half}}, 0.036 * size);
}

Result<Mesh> graspMesh(const char* name, double size)
{
	Result<scenes::GraspObject> object = scenes::makeGraspObject(name);
	if (!object) return object.error();
	Mesh mesh = std::move(object).value().mesh;
	const double scale = size / bounds(mesh).longestSide();
	for (Vec3& p : mesh.vertices) p *= scale;
	return mesh;
}

/// The skin is firm: with the hand's usual 5e7 Pa/m a fingertip stayed a sixth of a bar's thickness deep in a knot. Tray and pieces have
/// nothing set.
BulletHandSettings firmHand()
{
	BulletHandSettings settings;
	settings.skin = {1e9, 2};
	settings.palmForce = 25;
	return settings;
}

/// Position of the hand at a time. With `lies` it goes down from there until it carries the force with which it should press.
struct Key
{
	double time;  ///< [s]
	Vec3 wrist;   ///< [m]
	double claw;  ///< posture of the fingers: 0 flat, 1 bent
	bool lies;    ///< true: the hand lies down until the next key
};
constexpr Key kKeys[] = {{0.9, {0, 0.24, 0.33}, 0, false}, {1.4, {0, 0.13, 0.1}, 0, true}, {2.3, {0, 0.13, 0.1}, 0, false},
	{2.7, {0.02, 0.15, 0.05}, 1, false}, {3.1, {0.02, 0.115, 0.045}, 1, false}, {3.6, {0, 0.115, 0.11}, 1, false},
	{3.9, {0, 0.14, 0.1}, 0, true}};

/// Index of the last key that has begun.
size_t keyAt(double time)
{
	size_t i = 0;
	while (i + 1 < std::size(kKeys) && time >= kKeys[i + 1].time) ++i;
	return i;
}

/// A hand presses on a pile of concave bodies in a tray, rakes through it, and comes to rest on it.
class Pile : public HandDemo
{
public:
	Pile() { Pile::setContactCache({}); }
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> duck = graspMesh("duck", 1.1 * kSize), nut = graspMesh("nut", 0.9 * kSize);
		if (!duck || !nut) return duck ? nut.error() : duck.error();
		const std::pair<const char*, Mesh> kinds[] = {{"jack", jackMesh(1.1 * kSize)},
			{"ring", makeTorusMesh(0.36 * kSize, 0.14 * kSize, 48, 20)}, {"knot", knotMesh(1.1 * kSize)}, {"duck", std::move(duck).value()},
			{"nut", std::move(nut).value()}};
		for (const auto& [name, mesh] : kinds)
		{
			SolidPtr solid;
			if (auto error = makeSolid(solid, name, mesh, kSpheres, options, true)) return error;
			m_depths.push_back(std::make_unique<scenes::MeshDepth>(solid->mesh));
			m_kinds.push_back(std::move(solid));
		}
		if (auto error = prepareHand({}, options)) return error;
		for (size_t i = 0; i < kHandParts; ++i) m_partDepths[i] = std::make_unique<scenes::MeshDepth>(model().parts[i].mesh);
		return std::nullopt;
	}
	double duration() const override { return 6; }
	Viewpoint viewpoint() const override { return {{0, 0.045, 0.01}, 0.5, 0.7, 0.8}; }
	DrawChoice firstChoice() const override { return {.patches = false, .wrenches = false}; }
	/// Allows only exact cached results. With results that follow the motion to first order, a contact among thin bars was once wrong by
	/// half of its force.
	void setContactCache(const ContactCacheChoice& contactCache) override
	{
		HandDemo::setContactCache({contactCache.on, 0, contactCache.forceError});
	}
	std::vector<Parameter> parameters() override
	{
		return {{"hand presses with", "N", &m_press, 1, 60, false, false}, {"friction", "", &m_friction, 0, 1, true, false}};
	}
	std::vector<Figure> figures() const override;

protected:
	void leave() override
	{
		m_audit.reset();
		HandDemo::leave();
	}
	std::optional<Error> build() override;
	HandPosture motion(double time) const override;
	void beforeStep(double h) override
	{
		HandDemo::beforeStep(h);
		m_audit->beforeStep(h);
	}
	void afterStep(double h) override;
	void decorate(const DrawChoice& choice, DrawList& list) override
	{
		list.gridCell = 0.05;
		list.groundHeight = -2 * kBoard;
		drawHand(choice, list);
	}
	double arrowForce() const override { return 5; }
	double arrowLength() const override { return 0.05; }

private:
	void addTray(DemoWorld& w);
	void lookForDepth();
	bool isInPile(const btCollisionObject* object) const { return object->getUserIndex() >= 0; }

	std::vector<SolidPtr> m_kinds;
	std::vector<std::unique_ptr<scenes::MeshDepth>> m_depths;  // one for each kind
	std::unique_ptr<scenes::MeshDepth> m_partDepths[kHandParts];
	std::vector<std::pair<Vec3, Vec3>> m_boards;  // half sides and centres
	std::unique_ptr<btEnergyAudit> m_audit;
	const BulletHandSettings m_settings = firmHand();
	Vec3 m_onPile;  // impulse of tray and hand on the pile so far [N s]
	Vec3 m_onParts[kHandParts], m_byCouplings[kHandParts];
	double m_couplingShare = 0, m_inTray = 0, m_inHand = 0, m_nextLook = 0, m_mass = 0, m_sunk = 0, m_carries = 0, m_meanCarries = 0;
	double m_press = 20, m_friction = 0.4;
};

HandPosture Pile::motion(double time) const
{
	HandPosture flat, claw;
	for (FingerPosture* f : {&flat.index, &flat.middle, &flat.ring, &flat.little}) *f = {0.1, 0.15, 0.1, 0};
	for (FingerPosture* f : {&claw.index, &claw.middle, &claw.ring, &claw.little}) *f = {0.75, 0.6, 0.35, 0};
	claw.thumb.radial = 0.9;
	const Key &from = kKeys[keyAt(time)], &to = kKeys[std::min(keyAt(time) + 1, std::size(kKeys) - 1)];
	const double s = to.time > from.time ? std::clamp((time - from.time) / (to.time - from.time), 0.0, 1.0) : 0, u = s * s * (3 - 2 * s);
	HandPosture p = between(flat, claw, from.claw + u * (to.claw - from.claw));
	p.X_WR = {};
	p.X_WR.translation = from.wrist + u * (to.wrist - from.wrist) - Vec3{0, m_sunk, 0};
	return p;
}

void Pile::addTray(DemoWorld& w)
{
	const double x = kInside.x, y = kInside.y, z = kInside.z, t = kBoard, high = 0.5 * y + t;
	// The boards overlap, so that their seams have no surface outside another board.
	m_boards = {{{x + 2 * t, t, z + 2 * t}, {0, -t, 0}}, {{t, high, z + 2 * t}, {x + t, high - 2 * t, 0}},
		{{t, high, z + 2 * t}, {-x - t, high - 2 * t, 0}}, {{x + 2 * t, high, t}, {0, high - 2 * t, z + t}},
		{{x + 2 * t, high, t}, {0, high - 2 * t, -z - t}}};
	for (const auto& [half, middle] : m_boards)
	{
		BodySetup board;
		board.name = "tray";
		board.fixed = true;
		board.friction = 1;
		board.colour = {0.72f, 0.60f, 0.45f};
		board.X_WM.translation = middle;
		if (btRigidBody* added = w.addShape(std::make_unique<btBoxShape>(toBullet(half)), makeBoxMesh(half), std::move(board)))
			added->setUserIndex(-1);
	}
}

std::optional<Error> Pile::build()
{
	DemoWorld& w = addWorld();
	w.addPlane({0, 1, 0}, -2 * kBoard, 1);
	addTray(w);
	std::mt19937_64 random(3);
	std::normal_distribution<double> normal;
	m_mass = 0;
	for (int i = 0; i < kBodies; ++i)
	{
		const size_t kind = size_t(i) % m_kinds.size();
		BodySetup body;
		body.name = m_kinds[kind]->name + " " + std::to_string(i / int(m_kinds.size()) + 1);
		body.friction = m_friction;
		body.colour = bodyColour(int(kind));
		body.X_WM.rotation = rotationMatrix(quaternionFromRotationVector({normal(random), normal(random), normal(random)}));
		const int layer = i / (kColumns * kColumns), row = i / kColumns % kColumns, column = i % kColumns;
		body.X_WM.translation = {0.065 * (column - 1), 0.045 + 0.075 * layer, 0.065 * (row - 1)};
		btRigidBody* added = w.add(m_kinds[kind], std::move(body));
		if (!added) return std::nullopt;
		added->setUserIndex(int(kind));
		m_mass += 1 / double(added->getInvMass());
	}
	if (auto error = putHand(w, m_settings)) return error;
	m_audit = std::make_unique<btEnergyAudit>(w.bullet(), w.volumetric()->contacts());
	m_onPile = {};
	for (int i = 0; i < kHandParts; ++i) m_onParts[i] = m_byCouplings[i] = {};
	m_couplingShare = m_inTray = m_inHand = m_nextLook = m_sunk = m_carries = m_meanCarries = 0;
	return std::nullopt;
}

void Pile::afterStep(double h)
{
	m_audit->afterStep();
	m_carries = 0;
	for (const Vec3& force : parts().touch(h).force) m_carries += force.y;
	m_meanCarries += h / kMeanOver * (m_carries - m_meanCarries);
	m_sunk = kKeys[keyAt(time())].lies ? m_sunk + h * std::clamp(kSinking * (1 - m_carries / m_press), -kSinking, kSinking)
									   : std::max(m_sunk - h * kSinking, 0.0);
	const btISTContactStore& store = world().volumetric()->contacts();
	for (const btISTContact* contact : store.contacts())
	{
		if (!touchedInLastStep(store, *contact)) continue;
		Vec3 onA;
		for (int i = 0; i < contact->patchCount; ++i) onA += contact->impulses[i].force;
		const bool a = isInPile(contact->bodyA), b = isInPile(contact->bodyB);
		if (a != b) m_onPile += a ? onA : -onA;
		if (const int part = parts().partOf(contact->bodyA); part >= 0) m_onParts[part] += onA;
		if (const int part = parts().partOf(contact->bodyB); part >= 0) m_onParts[part] -= onA;
	}
	for (int i = 0; i < kHandParts; ++i)
	{
		const Vec3 pull = parts().coupling(i).force;
		m_byCouplings[i] += h * pull;
		m_couplingShare = std::max(m_couplingShare, norm(pull) / (i == kHandPart ? m_settings.palmForce : m_settings.maxForce));
	}
	if (time() < m_nextLook) return;
	m_nextLook += kLookEvery;
	lookForDepth();
}

void Pile::lookForDepth()
{
	for (const DemoWorld::Body& b : world().bodies())
	{
		if (!isInPile(b.body.get())) continue;
		const scenes::MeshDepth& depth = *m_depths[size_t(b.body->getUserIndex())];
		const Pose X = b.X_WP();
		for (const auto& [half, middle] : m_boards)
			m_inTray = std::max(m_inTray, scenes::deepestInBox(half, {{}, middle}, depth.mesh(), X));
		for (int i = 0; i < kHandParts; ++i) m_inHand = std::max(m_inHand, scenes::deepestEither(depth, X, *m_partDepths[i], X_WB(i)));
	}
}

std::vector<Figure> Pile::figures() const
{
	const double whole = m_mass * kGravity * time();
	Vec3 pile;
	double inTray = 0, couplings = 0, off = 0, fastest = 0;
	for (const DemoWorld::Body& b : world().bodies())
	{
		if (!isInPile(b.body.get())) continue;
		const Vec3 at = b.X_WP().translation, v = toVec3(b.body->getLinearVelocity());
		pile += v / double(b.body->getInvMass());
		inTray += std::fabs(at.x) < kInside.x && std::fabs(at.z) < kInside.z && at.y > 0 && at.y < 3 * kInside.y;
		fastest = std::max(fastest, norm(v));
	}
	for (int i = 0; i < kHandParts; ++i)
	{
		const btRigidBody& part = parts().body(i);
		couplings += norm(m_byCouplings[i]);
		off += norm(m_onParts[i] + m_byCouplings[i] - toVec3(part.getLinearVelocity()) / double(part.getInvMass()));
	}
	// A body that is less deep than half of a finger (8 mm), or of a board (12 mm), has not passed through it. The impulse of tray and
	// hand on the pile, less the pile's momentum, is its weight times the time (Newton).
	const Vec3 carried = m_onPile - pile;
	const btEnergyBalance& t = m_audit->total();
	return {{"impulse that carried the pile, for weight times time", "N s", carried.y, whole, 1e-3 * whole},
		{"the same, sideways", "N s", std::hypot(carried.x, carried.z), 0, 1e-3 * whole},
		{"of contacts and couplings on the hand, off Newton's law", "%", couplings > 0 ? 100 * off / couplings : 0, 0, 0.1},
		{"strongest coupling, of what it may exert", "%", 100 * m_couplingShare, 50, 50.5},
		{"bodies that were not raked out of the tray", "", inTray},
		{"deepest in the tray's boards, on the triangles", "mm", 1e3 * m_inTray, 0, 12},
		{"deepest in the hand, on the triangles", "mm", 1e3 * m_inHand, 0, 8}, {"fastest body", "m/s", fastest},
		{"energy that came in", "J", t.injected},
		{"of it without a name", "%", t.injected > 0 ? 100 * std::fabs(t.residual) / t.injected : 0, 0, 0.5},
		{"of it made by the finite step", "%", t.injected > 0 ? 100 * std::max(-t.numerical, 0.0) / t.injected : 0, 0, 0.5},
		{"force that the pile carries the hand with, mean of half a second", "N", m_meanCarries, m_press, 0.1 * m_press}};
}
}  // namespace

std::unique_ptr<BrowsableDemo> makePile() { return std::make_unique<Pile>(); }
}  // namespace browser
