// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Json/JsonValue.h"
#include "TestSupport/SceneFiles/SceneFile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

// data/scenes/scene.schema.json tells editors what a scene file may hold. These tests ask the reader for its fields, types, bounds and
// choices, by the sentences with which it refuses wrong ones, and compare.

using namespace ist;
using namespace scenes;

namespace
{
std::string textOf(const std::filesystem::path& file)
{
	std::ifstream in(file, std::ios::binary);
	std::ostringstream text;
	text << in.rdbuf();
	return text.str();
}

const JsonValue& schema()
{
	static const JsonValue value = parseJson(textOf(std::string(SCENE_FOLDER) + "/scene.schema.json")).value;
	return value;
}

const JsonValue& resolved(const JsonValue& rule)
{
	const JsonValue* ref = rule.find("$ref");
	const std::string prefix = "#/definitions/";
	return ref ? schema()["definitions"][ref->text().substr(prefix.size())] : rule;
}

/// The rules of JSON Schema that the file uses. Returns what is wrong; empty: nothing.
std::string violation(const JsonValue& value, const JsonValue& unresolved, const std::string& at = "")
{
	const JsonValue& rule = resolved(unresolved);
	const std::string type = rule["type"].text();
	const bool whole = value.isNumber() && value.number() == std::floor(value.number());
	if ((type == "object" && !value.isObject()) || (type == "array" && !value.isList()) || (type == "string" && !value.isText()) ||
		(type == "boolean" && !value.isFlag()) || (type == "number" && !value.isNumber()) || (type == "integer" && !whole))
		return at + ": wants the type " + type;
	if (rule.contains("const") && !(value == rule["const"])) return at + ": wants " + rule["const"].dump();
	bool listed = !rule.contains("enum");
	for (const JsonValue& choice : rule["enum"]) listed = listed || value == choice;
	if (!listed) return at + ": wants one of " + rule["enum"].dump();
	if (rule.contains("minimum") && value.number() < rule["minimum"].number()) return at + ": is too small";
	if (rule.contains("maximum") && value.number() > rule["maximum"].number()) return at + ": is too large";
	if (rule.contains("minLength") && value.text().empty()) return at + ": is empty";
	if (rule.contains("pattern") && value.text().find(rule["pattern"].text()) == std::string::npos) return at + ": does not fit";
	if (rule.contains("minItems") && double(value.size()) < rule["minItems"].number()) return at + ": has too few items";
	if (rule.contains("maxItems") && double(value.size()) > rule["maxItems"].number()) return at + ": has too many items";
	for (const JsonValue& name : rule["required"])
		if (value.isObject() && !value.contains(name.text())) return at + "." + name.text() + ": is missing";
	if (value.isList() && rule.contains("items"))
		for (size_t i = 0; i < value.size(); ++i)
			if (const std::string bad = violation(value[i], rule["items"], at + "[" + std::to_string(i) + "]"); !bad.empty()) return bad;
	if (value.isObject() && rule.contains("properties"))
		for (const auto& [name, field] : value.fields())
		{
			const JsonValue* known = rule["properties"].find(name);
			if (!known && rule.contains("additionalProperties")) return at + "." + name + ": is unknown";
			if (!known) continue;
			if (const std::string bad = violation(field, *known, at + "." + name); !bad.empty()) return bad;
		}
	for (const JsonValue& each : rule["allOf"])
		if (const std::string bad = violation(value, each, at); !bad.empty()) return bad;
	int fitting = 0;
	for (const JsonValue& each : rule["oneOf"]) fitting += violation(value, each).empty();
	if (rule.contains("oneOf") && fitting != 1) return at + ": fits " + std::to_string(fitting) + " of the choices";
	if (rule.contains("not") && violation(value, rule["not"]).empty()) return at + ": fits what it must not";
	if (rule.contains("if") && violation(value, rule["if"]).empty()) return violation(value, rule["then"], at);
	return "";
}

std::string violation(const std::string& text) { return violation(parseJson(text).value, schema()); }

/// Texts of scenes for one definition of the schema. The field that is asked for takes the place of @.
std::vector<std::string> scenesFor(const std::string& definition)
{
	const std::string assets = R"("assets": [{"name": "ball", "shape": "sphere"}], )";
	const std::string bodies = R"("bodies": [{"name": "floor", "plane": {}}, {"name": "ball", "asset": "ball"}])";
	const std::string start = R"({"schema": 1, )" + assets + bodies;
	const auto hand = [&](const std::string& fields) {
		return start + R"(, "duration": 1, "hand": {"device": "sim:sigma7")" + fields + "}}";
	};
	const auto asset = [](const std::string& kind) {
		return R"({"schema": 1, "bodies": [{"name": "floor", "plane": {}}], "assets": [{@"name": "a", )" + kind + "}]}";
	};
	const auto body = [&](const std::string& kind) {
		return R"({"schema": 1, )" + assets + R"("bodies": [{@"name": "a", )" + kind + "}]}";
	};
	std::vector<std::string> scenes;
	if (definition.empty())
		for (const char* topology : {R"("topology": "local-model", )", ""})
			scenes.push_back(R"({@"schema": 1, )" + std::string(topology) + assets + bodies + "}");
	if (definition == "asset")
	{
		for (const char* shape : {"box", "sphere", "capsule", "cylinder", "ring", "crown", "sword", "tube"})
			scenes.push_back(asset("\"shape\": \"" + std::string(shape) + "\""));
		scenes.push_back(asset("\"mesh\": \"a.obj\""));
		scenes.push_back(asset("\"ist\": \"a.ist\""));
	}
	if (definition == "material") return {start + R"(, "materials": [{@"name": "m"}]})"};
	if (definition == "body")
		for (const char* kind : {"\"asset\": \"ball\"", "\"plane\": {}", "\"box\": [1, 1, 1]", "\"sphere\": 1"})
			scenes.push_back(body(kind));
	if (definition == "plane") return {R"({"schema": 1, "bodies": [{"name": "floor", "plane": {@"normal": [0, 1, 0]}}]})"};
	if (definition == "region") return {start + R"(, "region": {@"lower": [0, 0, 0], "upper": [1, 1, 1]}})"};
	if (definition == "hand")
		for (const char* tool : {R"(, @"tool": "ball")", R"(, @"parts": {})"}) scenes.push_back(hand(tool));
	if (definition == "origin") return {hand(R"(, "tool": "ball", "origin": {@"turn": [0, 0, 0]})")};
	if (definition == "parts") return {hand(R"(, "parts": {@"friction": 1})"), hand(R"(, "parts": {@"spheres": 9})")};
	if (definition == "coupling")
		return {hand(R"(, "tool": "ball", "coupling": {@"static": true})"), hand(R"(, "tool": "ball", "coupling": {@"damping": 1})")};
	if (definition == "keyFrame") return {hand(R"(, "tool": "ball", "path": [{@"time": 1}])")};
	if (definition == "hook")
		for (const JsonValue& on : schema()["definitions"]["hook"]["properties"]["on"]["enum"])
			for (const JsonValue& action : schema()["definitions"]["hook"]["properties"]["do"]["enum"])
				for (const char* rest :
					{"", ", \"file\": \"a.csv\"", ", \"what\": \"forces\"", R"(, "what": "pair", "pair": ["ball", "floor"])"})
				{
					const std::string whole = hand(R"(, "tool": "ball")");
					const std::string text = whole.substr(0, whole.size() - 1) + R"(, "pairs": [["ball", "floor"]], "hooks": [{@"on": )" +
						on.dump() + ", \"do\": " + action.dump() + rest + "}]}";
					std::string plain = text;
					if (parseScene("s.json", plain.erase(plain.find('@'), 1), "")) scenes.push_back(text);
				}
	return scenes;
}

std::string refusalWith(std::string scene, const std::string& field)
{
	const Result<Scene> read = parseScene("s.json", scene.replace(scene.find('@'), 1, field), "");
	return read ? "" : read.error().message;
}

const char* const kDefinitions[] = {
	"", "asset", "material", "body", "plane", "region", "hand", "origin", "parts", "coupling", "keyFrame", "hook"};

const JsonValue& propertiesOf(const std::string& definition)
{
	const JsonValue& all = schema()["definitions"];
	if (definition.empty()) return schema()["properties"];
	if (definition == "region") return schema()["properties"]["region"]["properties"];
	if (definition == "plane") return all["body"]["properties"]["plane"]["properties"];
	if (definition == "origin") return all["hand"]["properties"]["origin"]["properties"];
	return all[definition]["properties"];
}

/// The fields that the reader names where one is unknown.
std::set<std::string> fieldsOfReader(const std::string& definition)
{
	std::set<std::string> fields;
	for (const std::string& scene : scenesFor(definition))
	{
		const std::string refusal = refusalWith(scene, "\"nosuch\": 1, "), known = "known ones are ";
		const size_t at = refusal.find(known);
		EXPECT_NE(at, std::string::npos) << scene << "\n" << refusal;
		std::istringstream list(at == std::string::npos ? "" : refusal.substr(at + known.size()));
		for (std::string name; std::getline(list, name, ',');) fields.insert(name.substr(name.find_first_not_of(' ')));
	}
	return fields;
}
}  // namespace

TEST(SceneSchema, EverySceneThatIsCarriedFits)
{
	int found = 0;
	for (const auto& entry : std::filesystem::directory_iterator(SCENE_FOLDER))
	{
		if (entry.path().extension() != ".json" || entry.path().stem().extension() == ".schema") continue;
		const std::string text = textOf(entry.path());
		EXPECT_EQ(violation(text), "") << entry.path();
		EXPECT_EQ(parseJson(text).value["$schema"].text(), "scene.schema.json") << entry.path();
		++found;
	}
	EXPECT_GE(found, 5);
}

TEST(SceneSchema, HasTheFieldsOfTheReaderAndNoOther)
{
	for (const char* definition : kDefinitions)
	{
		std::set<std::string> inSchema;
		for (const auto& [name, rule] : propertiesOf(definition).fields()) inSchema.insert(name);
		EXPECT_EQ(inSchema, fieldsOfReader(definition)) << definition;
	}
}

// Each field is given a null in a scene where it stands, and the sentence says what the reader wants there.
TEST(SceneSchema, HasTheTypesBoundsAndChoicesOfTheReader)
{
	int compared = 0;
	for (const std::string definition : kDefinitions)
		for (const auto& [name, unresolved] : propertiesOf(definition).fields())
		{
			const JsonValue& rule = resolved(unresolved);
			const std::string field = definition + "." + name;
			std::string sentence;
			for (const std::string& scene : scenesFor(definition))
			{
				if (scene.find("\"" + name + "\":", scene.find('@')) != std::string::npos) continue;
				const std::string refusal = refusalWith(scene, "\"" + name + "\": null, ");
				if (refusal.find(name + ": wants ") != std::string::npos) sentence = refusal.substr(refusal.find(": wants ") + 2);
			}
			// A field that every scene has, or of which only one may be there, is not asked for.
			if (sentence.empty()) continue;
			++compared;
			double least = 0, most = 0;
			const std::string type = rule["type"].text();
			if (std::sscanf(sentence.c_str(), "wants a number from %lf to %lf", &least, &most) == 2)
			{
				EXPECT_TRUE(type == "number" || type == "integer") << field;
				EXPECT_EQ(rule["minimum"].number(), least) << field;
				EXPECT_EQ(rule["maximum"].number(), most) << field;
			}
			else if (std::sscanf(sentence.c_str(), "wants three numbers of at most %lf", &most) == 1)
			{
				EXPECT_EQ(rule["items"]["maximum"].number(), most) << field;
				EXPECT_EQ(rule["items"]["minimum"].number(), -most) << field;
				EXPECT_EQ(rule["minItems"].number(), 3) << field;
			}
			else if (sentence.find("wants true or false") == 0) EXPECT_EQ(type, "boolean") << field;
			else if (sentence.find("wants a text in quotes") == 0) EXPECT_TRUE(type == "string" || rule.contains("enum")) << field;
			else if (sentence.find("wants a list in brackets") == 0) EXPECT_EQ(type, "array") << field;
			else if (sentence.find("wants an object in braces") == 0) EXPECT_EQ(type, "object") << field;
			else ADD_FAILURE() << field << ": " << sentence;
		}
	EXPECT_GT(compared, 55);
}

TEST(SceneSchema, HasTheChoicesOfTheReader)
{
	for (const auto& [definition, name] :
		std::vector<std::pair<std::string, std::string>>{{"", "topology"}, {"hook", "when"}, {"hook", "to"}, {"hook", "start"}})
	{
		std::set<std::string> choices, inSchema;
		for (const std::string& scene : scenesFor(definition))
		{
			const std::string refusal = refusalWith(scene, "\"" + name + "\": \"nosuch\", "), of = "wants one of ";
			const size_t at = refusal.find(of);
			if (refusal.find(name + ": wants") == std::string::npos || at == std::string::npos) continue;
			const size_t from = at + of.size(), to = refusal.find(", not nosuch");
			std::istringstream list(refusal.substr(from, to - from));
			for (std::string choice; std::getline(list, choice, ',');) choices.insert(choice.substr(choice.find_first_not_of(' ')));
		}
		for (const JsonValue& choice : propertiesOf(definition)[name]["enum"]) inSchema.insert(choice.text());
		EXPECT_EQ(choices, inSchema) << name;
	}
	for (const auto& [text, wanted] :
		std::vector<std::pair<std::string, std::string>>{
			{R"({"schema": 1, "bodies": [], "assets": [{"name": "a", "shape": "x"}]})", "shape"},
			{R"({"schema": 1, "bodies": [{"name": "f", "plane": {}}], "hooks": [{"on": "x", "do": "log"}]})", "on"},
			{R"({"schema": 1, "bodies": [{"name": "f", "plane": {}}], "hooks": [{"on": "fault", "do": "x"}]})", "do"},
			{R"({"schema": 1, "bodies": [{"name": "f", "plane": {}}], "hooks": [{"on": "button", "do": "switch", "what": "x"}]})", "what"}})
	{
		std::string all;
		for (const JsonValue& choice : propertiesOf(wanted == "shape" ? "asset" : "hook")[wanted]["enum"])
			all += (all.empty() ? "" : ", ") + choice.text();
		const Result<Scene> read = parseScene("s.json", text, "");
		ASSERT_FALSE(read);
		EXPECT_NE(read.error().message.find(wanted + ": wants one of " + all + ", not x"), std::string::npos) << read.error().message;
	}
}

TEST(SceneSchema, RefusesWhatTheReaderRefuses)
{
	const std::string good = R"({"$schema": "scene.schema.json", "schema": 1, "bodies": [{"name": "floor", "plane": {}}],
		"hands": [{"name": "h", "device": "motion:a", "parts": {}}], "hooks": [{"on": "button", "do": "switch", "what": "forces"}]})";
	EXPECT_EQ(violation(good), "");
	for (const auto& [from, to] :
		std::vector<std::pair<std::string, std::string>>{{"\"schema\": 1, ", ""}, {"\"schema\": 1", "\"schema\": 2"},
			{"\"plane\": {}", "\"plan\": {}"}, {"\"plane\": {}", "\"plane\": {}, \"sphere\": 1"}, {"\"plane\": {}", "\"plane\": 1"},
			{"\"parts\": {}", "\"parts\": {}, \"tool\": \"floor\""}, {"\"parts\": {}", "\"parts\": {\"spheres\": 1.5}"},
			{"\"name\": \"h\", ", ""}, {"motion:a", "motion"}, {"\"hands\"", "\"hand\": {}, \"hands\""}, {"\"button\"", "\"press\""},
			{", \"what\": \"forces\"", ""}, {"\"bodies\": [", "\"duration\": 0, \"bodies\": ["}})
	{
		std::string bad = good;
		ASSERT_NE(bad.find(from), std::string::npos) << from;
		bad.replace(bad.find(from), from.size(), to);
		EXPECT_NE(violation(bad), "") << bad;
		EXPECT_FALSE(parseScene("s.json", bad, "")) << bad;
	}
}
