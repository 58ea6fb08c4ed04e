// SPDX-License-Identifier: Zlib
#include "BulletHapticForce/World/btISTSceneReport.h"

#include "BulletHapticForce/World/btISTSubsteps.h"
#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Registry/btISTShapeParts.h"

#include "BulletCollision/BroadphaseCollision/btOverlappingPairCache.h"
#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "BulletCollision/CollisionShapes/btCollisionShape.h"
#include "BulletCollision/NarrowPhaseCollision/btPersistentManifold.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace
{
/// Number with so many digits, and with a decimal point in every locale, because programs read the report too.
std::string number(double value, int digits)
{
	char text[32];
	return std::string(text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr);
}

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
	return std::string("the other shape (") + (treeA ? b : a)->getName() +
		") has neither a tree nor a closed form, or the pair is not watched, of skewed axes, or began with other shapes";
}

std::string whyModel(const btISTContact& contact)
{
	if (contact.treeB) return "both have trees";
	return contact.halfSpace ? "a plane: its closed form is exact" : "the other shape is known in closed form";
}

std::string whyUse(const btISTContact& contact, double granted)
{
	switch (contact.use)
	{
	case btISTCachedResult::Apart: return "kept: the leaves cannot have met";
	case btISTCachedResult::Still: return "kept: neither has moved";
	case btISTCachedResult::Moved: return "kept: moved by less than " + number(100 * granted, 2) + " % of the force";
	case btISTCachedResult::Ask: break;
	}
	return "queried";
}

btISTPairReport ofContact(const btISTContact& contact, double thickness, bool asleep, const btISTContactCache& contactCache)
{
	btISTPairReport report;
	report.model = contact.treeB ? btISTPairReport::Trees : contact.halfSpace ? btISTPairReport::HalfSpace : btISTPairReport::ClosedForm;
	report.reason = whyModel(contact) + "; " + (asleep ? "not queried: both sleep" : whyUse(contact, contactCache.maxError));
	report.level = contact.level;
	report.patches = contact.patchCount;
	report.leafPairs = contact.total.pairs;
	const btISTPairConstants& c = contact.constants;
	report.force = norm(ist::pressureWrench(contact.total, {c.k, c.weightA, c.weightB}).force);
	report.k = c.k;
	report.stiffnessRule = c.rule;
	report.depth = contact.depth;
	report.deepest = contact.deepest / thickness;
	report.depthShare = contact.depth / thickness;
	report.load = c.load;
	if (contact.isDeep()) report.advice = btISTWarnings::advice(btISTWarning::Deep, c.rule);
	const double floor = btISTCachedResult::floorForce(contact);
	const double kept = contact.use == btISTCachedResult::Moved ? contactCache.maxError : 0;
	report.expectedError = std::hypot(contact.error.force / std::max(report.force, floor), kept);
	report.forceErrorBound = contact.accuracy.level >= 0 ? contact.accuracy.errorBound : std::numeric_limits<double>::quiet_NaN();
	report.withinTolerance = contact.accuracy.level >= 0 && contact.accuracy.kept;
	report.cost = contact.cost;
	if (contact.cost.asked > 0 && contact.cost.seconds > 0)
		report.savedSeconds = double(contact.cost.cached()) * contact.cost.querySeconds / double(contact.cost.asked) -
			(contact.cost.seconds - contact.cost.querySeconds);
	return report;
}

btISTPairReport withoutContact(const Objects& pair, const btISTRegistry& registry)
{
	btISTPairReport report;
	report.expectedError = report.forceErrorBound = std::numeric_limits<double>::quiet_NaN();
	if (sleeps(pair)) report.reason = "not looked at: both sleep or cannot move";
	else if (!pair.first->checkCollideWith(pair.second) || !pair.second->checkCollideWith(pair.first))
		report.reason = "the two are told not to collide";
	else
	{
		report.model = btISTPairReport::Stock;
		report.reason = whyStock(pair, registry);
	}
	return report;
}

/// What the solver did, and how often one of its searches ended early; empty where it has solved nothing.
std::string solverLine(const btVolumetricStatistics& s)
{
	if (s.islands + s.islandsTooLarge == 0) return {};
	std::string line = "solver: " + std::to_string(s.islands) + " islands solved at once";
	const auto add = [&line](uint64_t count, const char* what) {
		if (count > 0) line += ", " + std::to_string(count) + what;
	};
	add(s.islandsTooLarge, " too large for that, in Bullet's iterations");
	add(s.frictionNotConverged, " whose friction was not found to the end");
	add(s.activeSetsNotFound, " in which a patch that would push may have exerted nothing");
	add(s.solvedAgain, " solves repeated for bodies that were deflected");
	add(s.bodiesHeld, " bodies held for a part of a step");
	return line;
}

std::string solverJson(const btVolumetricStatistics& s)
{
	return "{\"islands\":" + std::to_string(s.islands) + ",\"islands_too_large\":" + std::to_string(s.islandsTooLarge) +
		",\"friction_not_converged\":" + std::to_string(s.frictionNotConverged) +
		",\"active_sets_not_found\":" + std::to_string(s.activeSetsNotFound) + ",\"solved_again\":" + std::to_string(s.solvedAgain) +
		",\"bodies_held\":" + std::to_string(s.bodiesHeld) + "}";
}

std::string numbered(const btCollisionObject* object) { return "body " + std::to_string(object->getWorldArrayIndex()); }

std::string jsonNumber(double value) { return std::isfinite(value) ? number(value, 9) : "null"; }

/// Length [bytes] of the character at the beginning of `text`, from table 3-7 of the Unicode standard; 0 where there is no valid
/// character.
size_t utf8Length(std::string_view text)
{
	const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
	const unsigned first = byte(0), second = byte(1);
	const size_t length = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
	// Each byte after the first is 10xxxxxx. The second byte is limited further, which excludes long forms of short characters,
	// surrogates, and values beyond U+10FFFF.
	for (size_t i = 1; i < length; ++i)
		if (byte(i) >> 6 != 2) return 0;
	const bool allowed = first == 0xe0 ? second >= 0xa0
		: first == 0xed                ? second < 0xa0
		: first == 0xf0                ? second >= 0x90
		: first == 0xf4                ? second < 0x90
									   : true;
	return allowed ? length : 0;
}

/// Names come from the program; bytes that are not valid UTF-8 become U+FFFD.
std::string quoted(std::string_view text)
{
	static constexpr char kDigits[] = "0123456789abcdef";
	std::string out = "\"";
	while (!text.empty())
	{
		const size_t length = utf8Length(text);
		const char c = text.front();
		if (length == 0) out += "\\ufffd";
		else if (c == '"' || c == '\\') out += {'\\', c};
		else if (static_cast<unsigned char>(c) < 0x20) out += std::string("\\u00") + kDigits[c >> 4] + kDigits[c & 15];
		else out += text.substr(0, length);
		text.remove_prefix(std::max<size_t>(1, length));
	}
	return out + "\"";
}

std::string costJson(const btISTQueryCost& cost)
{
	return "\"queries\":" + std::to_string(cost.asked) + ",\"kept\":" + std::to_string(cost.cached()) +
		",\"node_visits\":" + std::to_string(cost.nodeVisits) + ",\"ball_tests\":" + std::to_string(cost.ballTests) +
		",\"seconds\":" + jsonNumber(cost.seconds) + ",\"query_seconds\":" + jsonNumber(cost.querySeconds);
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
	case btISTStiffnessRule::Fluid: return "a fluid";
	case btISTStiffnessRule::OwnLoad: return "own load";
	case btISTStiffnessRule::PileLoad: return "load of the pile";
	case btISTStiffnessRule::Pressed: return "what presses";
	case btISTStiffnessRule::StepBound: return "bound of the step";
	}
	return "";
}

btISTSceneReport btISTSceneReport::of(btISTWorld& world, const Names& names)
{
	btISTSceneReport report = of(world.bullet(), world.registration(), names);
	report.solver = world.statistics();
	const btCollisionObjectArray& objects = world.bullet().getCollisionObjectArray();
	const auto nameOf = [&](const btCollisionObject* object) -> std::string {
		if (!object || objects.findLinearSearch2(const_cast<btCollisionObject*>(object)) < 0) return {};
		return names ? names(object) : numbered(object);
	};
	for (int i = 0; i < kWarningKinds; ++i)
	{
		const auto kind = btISTWarning(i);
		const btISTWarnings::Record& record = world.warnings()[kind];
		if (record.count > 0)
			report.warnings.push_back(
				{kind, record, nameOf(record.bodyA), nameOf(record.bodyB), btISTWarnings::advice(kind, world.warnings().ruleOf(kind))});
	}
	return report;
}

btISTSceneReport btISTSceneReport::of(const btCollisionWorld& world, btISTRegistration& registration, const Names& names)
{
	btISTSceneReport report;
	report.contactCache = registration.contactCache();
	report.acceptedError = registration.forceError();
	report.total = registration.store().cost();
	Contacts contacts;
	for (const btISTContact* contact : registration.store().contacts())
		contacts.emplace(sorted(contact->manifold->getBody0(), contact->manifold->getBody1()), contact);
	const auto add = [&](btISTPairReport pair, const btCollisionObject* a, const btCollisionObject* b) {
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
			// An older contact was handed back to Bullet.
			if (contact.stamp == 0 || (contact.stamp + 1 < step && !sleeps(pair))) continue;
			const double thickness = contact.treeB
				? contact.thickness()
				: std::min(contact.thickness(), btISTSubsteps::thickness(contact.shapeB, registration.registry()));
			add(ofContact(contact, thickness, sleeps(pair), report.contactCache), contact.bodyA, contact.bodyB);
			answered = true;
		}
		if (!answered) add(withoutContact(pair, registration.registry()), pair.first, pair.second);
	}
	return report;
}

std::vector<std::string> btISTSceneReport::lines() const
{
	std::vector<std::string> rows;
	std::string granted;
	if (contactCache.on && contactCache.maxError > 0) granted += ", " + number(100 * contactCache.maxError, 9) + " % granted";
	if (acceptedError > 0) granted += ", force error of " + number(100 * acceptedError, 9) + " % accepted";
	rows.push_back("contact cache " + std::string(contactCache.on ? "on" : "off") + granted + "; " + std::to_string(total.asked) +
		" queries, " + std::to_string(total.cached()) + " from the cache: a query in " + number(total.factor(), 3) +
		" steps of a pair; queries " + number(1e3 * total.querySeconds, 3) + " ms, saved about " + number(1e3 * savedSeconds, 3) + " ms");
	if (const std::string solved = solverLine(solver); !solved.empty()) rows.push_back(solved);
	for (const btISTWarningReport& w : warnings)
	{
		std::string line = "warning: " + std::string(btISTWarnings::nameOf(w.kind)) + ", " + std::to_string(w.record.count) + " times";
		if (!w.nameA.empty()) line += ", " + w.nameA;
		if (!w.nameB.empty()) line += " - " + w.nameB;
		if (w.record.bodyB)
			line += ", " + number(1e3 * w.record.depth, 3) + " mm deep (" + number(100 * w.record.share, 2) +
				" % of the thinner body), k " + number(w.record.k, 3) + " Pa/m";
		rows.push_back(line + ": " + w.advice);
	}
	for (size_t i = 0; i < pairs.size(); ++i)
	{
		const btISTPairReport& p = pairs[i];
		std::string line = namesA[i] + " - " + namesB[i] + ": " + btISTPairReport::nameOf(p.model);
		if (p.model > btISTPairReport::Stock)
			line += ", level " + std::to_string(p.level) + ", " + std::to_string(p.patches) + " patches, " + std::to_string(p.leafPairs) +
				" leaf pairs, " + number(p.force, 3) + " N";
		if (p.patches > 0 && std::isfinite(p.expectedError)) line += " within " + number(100 * p.expectedError, 2) + " %";
		if (p.deepest > 0)
			line += ", " + number(1e3 * p.depth, 3) + " mm deep (" + number(100 * p.depthShare, 2) + " % of the thinner body, at most " +
				number(100 * p.deepest, 2) + " %), k " + number(p.k, 3) + " Pa/m by " + btISTPairReport::nameOf(p.stiffnessRule);
		if (p.load > 0) line += " of " + number(p.load, 3) + " N";
		if (!p.advice.empty()) line += ": " + p.advice;
		if (std::isfinite(p.forceErrorBound))
			line += ", error bound " + number(100 * p.forceErrorBound, 2) + " %, " + number(100 * p.acceptedError, 2) + " % accepted" +
				(p.withinTolerance ? "" : ": not within it");
		if (p.cost.asked > 0) line += ", 1 query in " + number(p.cost.factor(), 3) + " steps";
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
	std::string out = "{\"schema\":1,\"economy\":" + std::string(contactCache.on ? "true" : "false") +
		",\"kept_error\":" + jsonNumber(contactCache.maxError) + ",\"accepted_error\":" + jsonNumber(acceptedError) +
		",\"queries\":" + std::to_string(total.asked) + ",\"kept\":" + std::to_string(total.cached()) +
		",\"factor\":" + jsonNumber(total.factor()) + ",\"seconds\":" + jsonNumber(total.seconds) +
		",\"query_seconds\":" + jsonNumber(total.querySeconds) + ",\"saved_seconds\":" + jsonNumber(savedSeconds) +
		",\"largest_kept_error\":" + jsonNumber(total.largestCacheError) + ",\"solver\":" + solverJson(solver) + ",\"warnings\":[";
	for (size_t i = 0; i < warnings.size(); ++i)
	{
		const btISTWarningReport& w = warnings[i];
		out += std::string(i ? "," : "") + "{\"kind\":" + quoted(btISTWarnings::nameOf(w.kind)) +
			",\"count\":" + std::to_string(w.record.count) + ",\"a\":" + quoted(w.nameA) + ",\"b\":" + quoted(w.nameB) +
			",\"k\":" + jsonNumber(w.record.k) + ",\"depth\":" + jsonNumber(w.record.depth) +
			",\"depth_share\":" + jsonNumber(w.record.share) + ",\"advice\":" + quoted(w.advice) + "}";
	}
	out += "],\"pairs\":[";
	for (size_t i = 0; i < pairs.size(); ++i)
	{
		const btISTPairReport& p = pairs[i];
		out += std::string(i ? "," : "") + "{\"a\":" + quoted(namesA[i]) + ",\"b\":" + quoted(namesB[i]) +
			",\"model\":" + quoted(btISTPairReport::nameOf(p.model)) + ",\"level\":" + std::to_string(p.level) +
			",\"reason\":" + quoted(p.reason) + ",\"patches\":" + std::to_string(p.patches) +
			",\"leaf_pairs\":" + std::to_string(p.leafPairs) + ",\"force\":" + jsonNumber(p.force) + ",\"k\":" + jsonNumber(p.k) +
			",\"stiffness_rule\":" + (p.model > btISTPairReport::Stock ? quoted(btISTPairReport::nameOf(p.stiffnessRule)) : "null") +
			",\"depth\":" + jsonNumber(p.depth) + ",\"depth_share\":" + jsonNumber(p.depthShare) + ",\"deepest\":" + jsonNumber(p.deepest) +
			",\"load\":" + jsonNumber(p.load) + ",\"advice\":" + quoted(p.advice) + ",\"expected_error\":" + jsonNumber(p.expectedError) +
			",\"accepted_error\":" + jsonNumber(p.acceptedError) + ",\"promised_error\":" + jsonNumber(p.forceErrorBound) +
			",\"promise_kept\":" +
			(!std::isfinite(p.forceErrorBound) ? "null"
					: p.withinTolerance        ? "true"
											   : "false") +
			"," + costJson(p.cost) + ",\"saved_seconds\":" + jsonNumber(p.savedSeconds) + "}";
	}
	return out + "]}";
}
