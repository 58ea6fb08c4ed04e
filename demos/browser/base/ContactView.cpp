// SPDX-License-Identifier: Zlib
#include "demos/browser/base/ContactView.h"

#include "BulletISTCollision/Core/Force/ContactPoints.h"

#include "BulletISTCollision/Registry/btISTConversion.h"
#include "BulletISTCollision/Registry/btISTShapeField.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr size_t kMostLeaves = 4000, kMostLenses = 6000;
constexpr Colour kMomentColour{0.42f, 0.20f, 0.62f};

void drawLeaves(const InnerSphereTree& tree, const Pose& X_WP, DrawList& list)
{
	const size_t stride = std::max<size_t>(1, tree.law.ballCount() / kMostLeaves);
	size_t i = 0;
	for (size_t slot = 0; slot < tree.law.slotCount(); ++slot)
	{
		const MomentEllipsoid ball = tree.law.ball(slot);
		if (!(ball.density > 0) || i++ % stride) continue;
		const Vec3 at = X_WP * (tree.origin + ball.center()), normal = X_WP.rotation * ball.normal();
		const Colour colour = levelColour(0.15 + 0.8 * norm(normal));
		list.discs.push_back({at, normalized(normal), 0.35 * ball.meanRadius(), 0.2 * ball.meanRadius(), colour});
		list.lines.push_back({at, at + ball.meanRadius() * normal, colour});
	}
}

/// Draws the leaves that reach into a closed form, projected onto its surface and coloured by their depth.
void drawFieldLenses(const btISTContact& contact, const btISTShapeField& shape, DrawList& list)
{
	const InnerSphereTree& tree = *contact.treeA;
	const Pose X_AF = contact.X_AB * shape.X_SF(), X_FA = inverse(X_AF);
	double deepest = 0;
	const size_t first = list.discs.size();
	std::vector<double> depths;
	for (size_t slot = 0; slot < tree.law.slotCount(); ++slot)
	{
		const MomentEllipsoid ball = tree.law.ball(slot);
		if (!(ball.density > 0)) continue;
		const Vec3 inField = X_FA * (tree.origin + ball.center()), n = X_AF.rotation * shape.field()->normal(inField);
		const double below = shape.field()->depth(inField), depth = std::sqrt(dot(n, ball.shape() * n)) + below;
		if (!(depth > 0)) continue;
		deepest = std::max(deepest, depth);
		depths.push_back(depth);
		list.discs.push_back({contact.X_WA * (tree.origin + ball.center() + below * n), contact.X_WA.rotation * n, 0.7 * ball.meanRadius(),
			std::min(0.5 * depth, 0.15 * ball.meanRadius()), {}});
	}
	for (size_t i = 0; i < depths.size(); ++i) list.discs[first + i].colour = pressureColour(depths[i] / deepest);
}

/// The trees that answered; the second is null for a closed form.
LevelPair answeringTrees(const btISTContact& contact)
{
	if (!contact.treeB) return {&contact.treeA->law, nullptr, 0, 0};
	return levelOf(*contact.treeA, *contact.treeB, contact.level);
}

Colour colourOfLevel(int level) { return shadeColour(levelShade(level)); }

/// Draws the balls of the tree that answered in the colour of its level. Returns their number.
size_t drawLevel(const BallTree& balls, const Vec3& origin, const Pose& X_WM, int level, DrawList& list)
{
	const size_t count = balls.ballCount(), stride = std::max<size_t>(1, count / kMostLeaves);
	size_t i = 0;
	for (size_t slot = 0; slot < balls.slotCount(); ++slot)
	{
		const MomentEllipsoid ball = balls.ball(slot);
		if (!(ball.density > 0) || i++ % stride) continue;
		const Vec3 normal = squaredNorm(ball.normal()) > 0 ? normalized(ball.normal()) : Vec3{0, 0, 1};
		list.discs.push_back({X_WM * (origin + ball.center()), X_WM.rotation * normal, 0.6 * ball.meanRadius(), 0.3 * ball.meanRadius(),
			colourOfLevel(level)});
	}
	return count;
}

/// The force on the moving body, out of the two opposite forces of a contact. If both bodies move, it is the upward one, on the carried
/// body.
Vec3 shownForce(const btCollisionObject& A, const btCollisionObject& B, const Vec3& onA)
{
	const bool movesA = !A.isStaticOrKinematicObject(), movesB = !B.isStaticOrKinematicObject();
	return movesA && (!movesB || onA.y >= 0) ? onA : -onA;
}
}  // namespace

std::string formatForce(double newton)
{
	struct Unit
	{
		double size;
		const char* name;
	};
	constexpr Unit kUnits[] = {{1e12, "TN"}, {1e9, "GN"}, {1e6, "MN"}, {1e3, "kN"}, {1, "N"}, {1e-3, "mN"}, {1e-6, "uN"}};
	Unit unit = newton == 0 ? Unit{1, "N"} : kUnits[6];
	for (const Unit& larger : kUnits)
		if (std::fabs(newton) >= larger.size)
		{
			unit = larger;
			break;
		}
	char text[40];
	std::snprintf(text, sizeof text, "%.3g %s", newton / unit.size, unit.name);
	return text;
}

void ContactView::drawBodies(DemoWorld& world, const DrawChoice& choice, DrawList& list) const
{
	const bool glass = choice.showsInside();
	for (const DemoWorld::Body& b : world.bodies())
	{
		const Pose X = b.X_WP();
		// Sleeping bodies are paler.
		const bool asleep = !b.body->isStaticOrKinematicObject() && !b.body->isActive();
		const Colour colour = asleep ? mixed(b.colour, {0.75f, 0.77f, 0.8f}, 0.6) : b.colour;
		if (choice.surfaces) list.surfaces.push_back({b.surface, X, colour, 1, glass && b.solid});
		if (choice.frames)
			for (int axis = 0; axis < 3; ++axis)
				list.lines.push_back({X.translation, X.translation + 0.7 * b.surface->box.longestSide() * X.rotation.column(axis),
					bodyColour(axis == 0 ? 6
							: axis == 1  ? 2
										 : 5)});
		if (!b.solid) continue;
		b.solid->spheres.draw(choice, X, list);
		if (choice.leaves) drawLeaves(*b.solid->tree, X, list);
	}
}

/// Draws the points of the contact surface as discs. Returns false where leaves answered.
bool ContactView::drawContactSurface(const btISTContact& contact, const OverlapResult& answer, DrawList& list)
{
	m_points.resize(contactPointCount(answer));
	contactPoints(answer, {contact.constants.k, contact.constants.weightA, contact.constants.weightB}, m_points.data(), m_points.size());
	double most = 0;
	for (const ContactPoint& p : m_points) most = std::max(most, p.pressure);
	const size_t stride = std::max<size_t>(1, m_points.size() / kMostLenses);
	for (size_t i = 0; i < m_points.size(); i += stride)
	{
		const ContactPoint& p = m_points[i];
		if (!(p.pressure > 0)) continue;
		const double radius = 0.8 * std::sqrt(double(stride) * p.area / kPi);
		list.discs.push_back({contact.X_WA * (contact.treeA->origin + p.position), contact.X_WA.rotation * p.normal, radius, 0.1 * radius,
			pressureColour(p.pressure / most)});
	}
	return !m_points.empty();
}

void ContactView::drawLenses(const btISTContact& contact, DrawList& list)
{
	if (!contact.treeB)
	{
		const btISTShapeField shape(contact.bodyB->getCollisionShape());
		if (shape.field()) drawFieldLenses(contact, shape, list);
		return;
	}
	QueryOptions options;
	options.stiffness = options.patches = false;
	const Pose X_AB = inverse(contact.X_WA) * toPose(contact.bodyB->getWorldTransform());
	if (drawContactSurface(contact, queryOverlap(*contact.treeA, *contact.treeB, X_AB, m_workspace, options), list)) return;
	options.sortPairs = true;
	const OverlapResult result = queryOverlap(*contact.treeA, *contact.treeB, X_AB, m_workspace, options);
	if (result.status != QueryStatus::Ok || result.pairCount == 0) return;
	double thickest = 0;
	const auto thickness = [](const OverlapPair& p) { return p.area > 0 ? double(p.lens) / p.area : 0; };
	for (int i = 0; i < result.pairCount; ++i) thickest = std::max(thickest, thickness(result.pairs[i]));
	const size_t stride = std::max<size_t>(1, size_t(result.pairCount) / kMostLenses);
	for (int i = 0; i < result.pairCount; i += int(stride))
	{
		const OverlapPair& p = result.pairs[i];
		if (!(p.area > 0) || !(p.lens > 0)) continue;
		const double t = thickness(p);
		list.discs.push_back({contact.X_WA * (contact.treeA->origin + p.centroid), contact.X_WA.rotation * p.normal,
			0.8 * std::sqrt(p.area / kPi), 0.6 * t, pressureColour(t / thickest)});
	}
}

void ContactView::drawLevels(const btISTContact& contact, const LevelPair& trees, DrawList& list)
{
	const auto draw = [&](const btCollisionObject* body, const InnerSphereTree& tree, const BallTree& balls, const Pose& X_WM, int level) {
		// The same level of a body often answers for several pairs.
		if (!m_drawnLevels.insert({body, &balls}).second) return;
		const size_t count = drawLevel(balls, tree.origin, X_WM, level, list);
		m_ballsOfLevel[level] += count;
	};
	draw(contact.bodyA, *contact.treeA, *trees.treeA, contact.X_WA, trees.a);
	if (contact.treeB) draw(contact.bodyB, *contact.treeB, *trees.treeB, contact.X_WA * contact.X_AB, trees.b);
	if (!(contact.total.volume > 0)) return;
	char text[64];
	const auto pairs = static_cast<long long>(contact.total.pairs);
	if (contact.treeB) std::snprintf(text, sizeof text, "levels %d and %d: %lld pairs", trees.a, trees.b, pairs);
	else std::snprintf(text, sizeof text, "level 0: %lld leaves", pairs);
	list.texts.push_back(
		{contact.X_WA * (contact.treeA->origin + contact.total.firstMoment / contact.total.volume), text, {0.1f, 0.1f, 0.12f}});
}

void ContactView::addKeys(const DrawChoice& choice, DrawList& list) const
{
	for (const auto& [level, count] : m_ballsOfLevel)
		list.addKey(colourOfLevel(level),
			"level " + std::to_string(level) + (level == 0 ? ", the leaves: " : ": ") + std::to_string(count) + " balls answer");
	if (choice.pairs)
	{
		list.addKey({0, 0.8f, 0}, "pair that touches");
		list.addKey({0.8f, 0, 0}, "pair a tenth of the thinner body deep, or more");
	}
	if (choice.lenses && !list.discs.empty())
	{
		list.addKey(pressureColour(0.1), "least pressure");
		list.addKey(pressureColour(0.95), "most pressure");
	}
}

void ContactView::drawForce(const Vec3& at, const Vec3& force, DrawList& list) const
{
	const double strength = norm(force);
	if (!(strength > 0.02 * m_strongest)) return;
	// The limits keep small forces visible, and large ones inside the picture.
	const double length = m_arrowLength * std::clamp(strength / m_arrowForce, 0.25, 2.0);
	const Vec3 tip = at + length * normalized(force);
	list.arrows.push_back({at, tip, 0.035 * m_arrowLength, {0.80f, 0.18f, 0.12f}});
	// Only large forces get a text, because many texts would hide each other.
	if (strength > 0.4 * m_strongest) list.texts.push_back({tip, formatForce(strength), {0.55f, 0.08f, 0.04f}});
}

void ContactView::drawMoment(const Vec3& at, const Vec3& moment, double lever, DrawList& list) const
{
	const double strength = lever > 0 ? norm(moment) / lever : 0;
	if (!(strength > 0.25 * m_strongest)) return;
	const double length = m_arrowLength * std::clamp(strength / m_arrowForce, 0.25, 1.0);
	list.arrows.push_back({at, at + length * normalized(moment), 0.02 * m_arrowLength, kMomentColour});
	list.addKey(kMomentColour, "moment about a patch's middle");
}

void ContactView::drawStock(const DemoWorld& world, const DrawChoice& choice, DrawList& list)
{
	const std::vector<StockContact> contacts = world.stockContacts();
	for (const StockContact& c : contacts) m_strongest = std::max(m_strongest, norm(c.impulse) / world.lastStep());
	for (const StockContact& c : contacts)
	{
		if (choice.patches)
			for (const Vec3& p : c.points)
				list.discs.push_back({p, {0, 1, 0}, 0.03 * m_arrowLength, 0.03 * m_arrowLength, {0.05f, 0.05f, 0.08f}});
		if (choice.wrenches) drawForce(c.center, shownForce(*c.bodyA, *c.bodyB, c.impulse / world.lastStep()), list);
	}
}

void ContactView::drawForces(const DemoWorld& world, const btISTContact& contact, DrawList& list)
{
	for (int i = 0; i < contact.patchCount; ++i)
	{
		const OverlapIntegrals& patch = contact.patches[i];
		if (!(patch.volume > 0)) continue;
		const Vec3 center = contact.X_WA * (contact.treeA->origin + patch.firstMoment / patch.volume);
		const Vec3 force = shownForce(*contact.bodyA, *contact.bodyB, contact.impulses[i].force / world.lastStep());
		const double area = norm(patch.areaVector);
		drawForce(center, force, list);
		const double lever = std::sqrt(area / kPi);
		drawMoment(
			center, (dot(force, contact.impulses[i].force) < 0 ? -1 : 1) / world.lastStep() * contact.impulses[i].torque, lever, list);
	}
}

void ContactView::draw(DemoWorld& world, const DrawChoice& choice, double arrowForce, double arrowLength, DrawList& list)
{
	m_answering.clear();
	drawBodies(world, choice, list);
	world.debugLines(choice, list);
	if (!(world.lastStep() > 0)) return;
	m_arrowForce = arrowForce;
	m_arrowLength = arrowLength;
	m_strongest = 0;
	m_drawnLevels.clear();
	m_ballsOfLevel.clear();
	if (!world.volumetric()) return drawStock(world, choice, list);
	for (const btISTContact* contact : world.volumetric()->contacts().contacts())
		for (int i = 0; i < contact->patchCount; ++i)
			m_strongest = std::max(m_strongest, norm(contact->impulses[i].force) / world.lastStep());
	for (const btISTContact* contact : world.volumetric()->contacts().contacts())
	{
		if (contact->patchCount == 0) continue;
		const LevelPair trees = answeringTrees(*contact);
		m_answering.insert({trees.a, trees.b});
		if (choice.levels) drawLevels(*contact, trees, list);
		if (choice.lenses) drawLenses(*contact, list);
		if (choice.wrenches) drawForces(world, *contact, list);
	}
	addKeys(choice, list);
}
}  // namespace browser
