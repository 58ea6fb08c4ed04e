// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/btISTSceneReport.h"

#include "BulletHapticForce/btISTSubsteps.h"
#include "BulletHapticForce/btISTWorld.h"
#include "BulletISTCollision/Core/PressureField.h"
#include "BulletISTCollision/btISTShapeParts.h"

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

namespace
{
using Objects = std::pair<const btCollisionObject*, const btCollisionObject*>;
using Contacts = std::multimap<Objects, const btISTContact*>;

Objects sorted(const btCollisionObject* a, const btCollisionObject* b)
{
	return std::less<const btCollisionObject*>()(b, a) ? Objects(b, a) : Objects(a, b);
}

bool sleeps(const Objects& pair) { return !pair.first->isActive() && !pair.second->isActive(); }

bool hasTree(const btCollisionShape* shape, const btISTRegistry& registry)
{
	return btISTAnyPart(shape, [&](const btCollisionShape* part) { return registry.find(part) != nullptr; });
}

std::string whyStock(const Objects& pair, const btISTRegistry& registry)
{
	const btCollisionShape *a = pair.first->getCollisionShape(), *b = pair.second->getCollisionShape();
	const bool treeA = hasTree(a, registry), treeB = hasTree(b, registry);
	if (!treeA && !treeB) return "neither shape has a tree";
	if (treeA && treeB) return "not watched, scaled, of skewed axes, or not looked at yet";
	return std::string("the other shape (") + (treeA ? b : a)->getName() + ") has neither a tree nor a closed form, or the pair is not watched, of skewed axes, or began with other shapes";
}

std::string whyModel(const btISTContact& contact)
{
	if (contact.treeB) return "both have trees";
	return contact.halfSpace ? "a plane: exact caps of the leaves" : "the other shape is known in closed form";
}

std::string whyUse(const btISTContact& contact, double granted)
{
	char text[96];
	switch (contact.use)
	{
		case btISTKeptResult::Apart: return "kept: the leaves cannot have met";
		case btISTKeptResult::Still: return "kept: neither has moved";
		case btISTKeptResult::Moved:
			std::snprintf(text, sizeof text, "kept: moved by less than %.2g %% of the force", 100 * granted);
			return text;
		case btISTKeptResult::Ask: break;
	}
	return "queried";
}

btISTPairReport ofContact(const btISTContact& contact, double thickness, bool asleep, const btISTEconomy& economy)
{
	btISTPairReport report;
	report.model = contact.treeB ? btISTPairReport::Trees : contact.halfSpace ? btISTPairReport::HalfSpace : btISTPairReport::ClosedForm;
	report.reason = whyModel(contact) + "; " + (asleep ? "not queried: both sleep" : whyUse(contact, economy.keptError));
	report.level = contact.level;
	report.patches = contact.patchCount;
	report.leafPairs = contact.total.pairs;
	const btISTPairConstants& c = contact.constants;
	report.force = norm(ist::pressureWrench(contact.total, {c.k, c.weightA, c.weightB}).force);
	report.k = c.k;
	report.stiffnessRule = c.rule;
	report.depth = contact.depth;
	report.deepest = contact.deepest / thickness;
	const double floor = btISTKeptResult::floorForce(contact);
	const double kept = contact.use == btISTKeptResult::Moved ? economy.keptError : 0;
	report.expectedError = std::hypot(contact.error.force / std::max(report.force, floor), kept);
	report.promisedError = contact.accuracy.level >= 0 ? contact.accuracy.promise : std::numeric_limits<double>::quiet_NaN();
	report.promiseKept = contact.accuracy.level >= 0 && contact.accuracy.kept;
	report.cost = contact.cost;
	if (contact.cost.asked > 0 && contact.cost.seconds > 0)
		report.savedSeconds = double(contact.cost.kept()) * contact.cost.querySeconds / double(contact.cost.asked) - (contact.cost.seconds - contact.cost.querySeconds);
	return report;
}

btISTPairReport withoutContact(const Objects& pair, const btISTRegistry& registry)
{
	btISTPairReport report;
	report.expectedError = report.promisedError = std::numeric_limits<double>::quiet_NaN();
	if (sleeps(pair))
		report.reason = "not looked at: both sleep or cannot move";
	else if (!pair.first->checkCollideWith(pair.second) || !pair.second->checkCollideWith(pair.first))
		report.reason = "the two are told not to collide";
	else
	{
		report.model = btISTPairReport::Stock;
		report.reason = whyStock(pair, registry);
	}
	return report;
}

std::string numbered(const btCollisionObject* object) { return "body " + std::to_string(object->getWorldArrayIndex()); }

std::string number(double value)
{
	char text[32];
	std::snprintf(text, sizeof text, "%.9g", value);
	return std::isfinite(value) ? text : "null";
}

std::string quoted(const std::string& text)
{
	std::string out = "\"";
	for (const char c : text)
	{
		char escaped[8];
		if (c == '"' || c == '\\') out += std::string("\\") + c;
		else if (static_cast<unsigned char>(c) >= 0x20) out += c;
		else std::snprintf(escaped, sizeof escaped, "\\u%04x", unsigned(c)), out += escaped;
	}
	return out + "\"";
}

std::string costJson(const btISTQueryCost& cost)
{
	return "\"queries\":" + std::to_string(cost.asked) + ",\"kept\":" + std::to_string(cost.kept()) + ",\"node_visits\":" + std::to_string(cost.nodeVisits) +
		   ",\"ball_tests\":" + std::to_string(cost.ballTests) + ",\"seconds\":" + number(cost.seconds) + ",\"query_seconds\":" + number(cost.querySeconds);
}
}  // namespace

const char* btISTPairReport::nameOf(Model model)
{
	switch (model)
	{
		case None: return "none";
		case Stock: return "bullet";
		case HalfSpace: return "tree on plane";
		case ClosedForm: return "tree on closed form";
		case Trees: return "tree on tree";
	}
	return "";
}

const char* btISTPairReport::nameOf(btISTStiffnessRule rule)
{
	switch (rule)
	{
		case btISTStiffnessRule::Given: return "given";
		case btISTStiffnessRule::OwnLoad: return "own load";
		case btISTStiffnessRule::PileLoad: return "load of the pile";
		case btISTStiffnessRule::StepBound: return "bound of the step";
	}
	return "";
}

btISTSceneReport btISTSceneReport::of(btISTWorld& world, const Names& names) { return of(world.bullet(), world.registration(), names); }

btISTSceneReport btISTSceneReport::of(const btCollisionWorld& world, btISTRegistration& registration, const Names& names)
{
	btISTSceneReport report;
	report.economy = registration.economy();
	report.acceptedError = registration.forceError();
	report.total = registration.store().cost();
	Contacts contacts;
	for (const btISTContact* contact : registration.store().contacts())
		contacts.emplace(sorted(contact->manifold->getBody0(), contact->manifold->getBody1()), contact);
	const auto add = [&](btISTPairReport pair, const btCollisionObject* a, const btCollisionObject* b)
	{
		pair.acceptedError = pair.model == btISTPairReport::Trees ? registration.forceErrorOf(a, b) : 0;
		pair.bodyA = a;
		pair.bodyB = b;
		report.savedSeconds += pair.savedSeconds;
		report.namesA.push_back(names ? names(a) : numbered(a));
		report.namesB.push_back(names ? names(b) : numbered(b));
		report.pairs.push_back(std::move(pair));
	};
	const uint64_t step = registration.store().step();
	const btBroadphasePairArray& found = const_cast<btCollisionWorld&>(world).getPairCache()->getOverlappingPairArray();
	for (int i = 0; i < found.size(); ++i)
	{
		const Objects pair = sorted(static_cast<const btCollisionObject*>(found[i].m_pProxy0->m_clientObject),
									static_cast<const btCollisionObject*>(found[i].m_pProxy1->m_clientObject));
		const auto range = contacts.equal_range(pair);
		bool answered = false;
		for (auto at = range.first; at != range.second; ++at)
		{
			const btISTContact& contact = *at->second;
			// An older one was handed back to Bullet.
			if (contact.stamp == 0 || (contact.stamp + 1 < step && !sleeps(pair))) continue;
			const double thickness = contact.treeB ? contact.thickness() : std::min(contact.thickness(), btISTSubsteps::thickness(contact.shapeB, registration.registry()));
			add(ofContact(contact, thickness, sleeps(pair), report.economy), contact.bodyA, contact.bodyB);
			answered = true;
		}
		if (!answered) add(withoutContact(pair, registration.registry()), pair.first, pair.second);
	}
	return report;
}

std::vector<std::string> btISTSceneReport::lines() const
{
	std::vector<std::string> rows;
	char row[256];
	std::string granted;
	if (economy.on && economy.keptError > 0) granted += ", " + number(100 * economy.keptError) + " % granted";
	if (acceptedError > 0) granted += ", force error of " + number(100 * acceptedError) + " % accepted";
	std::snprintf(row, sizeof row, "economy %s%s; %llu queries, %llu kept: a query in %.3g steps of a pair; queries %.3g ms, saved about %.3g ms",
				  economy.on ? "on" : "off", granted.c_str(),
				  static_cast<unsigned long long>(total.asked), static_cast<unsigned long long>(total.kept()), total.factor(), 1e3 * total.querySeconds, 1e3 * savedSeconds);
	rows.emplace_back(row);
	for (size_t i = 0; i < pairs.size(); ++i)
	{
		const btISTPairReport& p = pairs[i];
		std::snprintf(row, sizeof row, ": %s, level %d, %d patches, %lld leaf pairs, %.3g N", btISTPairReport::nameOf(p.model), p.level, p.patches,
					  static_cast<long long>(p.leafPairs), p.force);
		std::string line = namesA[i] + " - " + namesB[i] + (p.model > btISTPairReport::Stock ? row : std::string(": ") + btISTPairReport::nameOf(p.model));
		if (p.patches > 0)
		{
			std::snprintf(row, sizeof row, " (k %.3g Pa/m: %s; %.3g mm deep, at most %.2g %% of the thickness)", p.k, btISTPairReport::nameOf(p.stiffnessRule), 1e3 * p.depth, 100 * p.deepest);
			line += row;
		}
		if (p.patches > 0 && std::isfinite(p.expectedError))
		{
			std::snprintf(row, sizeof row, " within %.2g %%", 100 * p.expectedError);
			line += row;
		}
		if (std::isfinite(p.promisedError))
		{
			std::snprintf(row, sizeof row, ", promised within %.2g %%, %.2g %% accepted%s", 100 * p.promisedError, 100 * p.acceptedError, p.promiseKept ? "" : ": not kept");
			line += row;
		}
		if (p.cost.asked > 0)
		{
			std::snprintf(row, sizeof row, ", 1 query in %.3g steps", p.cost.factor());
			line += row;
		}
		rows.push_back(line + " (" + p.reason + ")");
	}
	return rows;
}

std::string btISTSceneReport::text() const
{
	std::string all;
	for (const std::string& line : lines()) all += line + "\n";
	return all;
}

std::string btISTSceneReport::json() const
{
	std::string out = "{\"schema\":1,\"economy\":" + std::string(economy.on ? "true" : "false") + ",\"kept_error\":" + number(economy.keptError) +
					  ",\"accepted_error\":" + number(acceptedError) + ",\"queries\":" + std::to_string(total.asked) + ",\"kept\":" + std::to_string(total.kept()) + ",\"factor\":" + number(total.factor()) +
					  ",\"seconds\":" + number(total.seconds) + ",\"query_seconds\":" + number(total.querySeconds) + ",\"saved_seconds\":" + number(savedSeconds) +
					  ",\"largest_kept_error\":" + number(total.largestKeptError) + ",\"pairs\":[";
	for (size_t i = 0; i < pairs.size(); ++i)
	{
		const btISTPairReport& p = pairs[i];
		out += std::string(i ? "," : "") + "{\"a\":" + quoted(namesA[i]) + ",\"b\":" + quoted(namesB[i]) + ",\"model\":" + quoted(btISTPairReport::nameOf(p.model)) +
			   ",\"level\":" + std::to_string(p.level) + ",\"reason\":" + quoted(p.reason) + ",\"patches\":" + std::to_string(p.patches) +
			   ",\"leaf_pairs\":" + std::to_string(p.leafPairs) + ",\"force\":" + number(p.force) + ",\"k\":" + number(p.k) + ",\"stiffness_rule\":" + (p.model > btISTPairReport::Stock ? quoted(btISTPairReport::nameOf(p.stiffnessRule)) : "null") +
			   ",\"depth\":" + number(p.depth) + ",\"deepest\":" + number(p.deepest) + ",\"expected_error\":" + number(p.expectedError) +
			   ",\"accepted_error\":" + number(p.acceptedError) + ",\"promised_error\":" + number(p.promisedError) + ",\"promise_kept\":" + (!std::isfinite(p.promisedError) ? "null" : p.promiseKept ? "true" : "false") + "," +
			   costJson(p.cost) + ",\"saved_seconds\":" + number(p.savedSeconds) + "}";
	}
	return out + "]}";
}
