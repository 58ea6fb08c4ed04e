// SPDX-License-Identifier: Zlib
#include "demos/scenes/Study/StudyFile.h"

#include "TestSupport/SceneFiles/JsonSource.h"

#include <algorithm>
#include <filesystem>

using namespace ist;
using Json = ist::JsonValue;

namespace scenes
{
namespace
{
constexpr double kLongestTrial = 1800;  // [s]; every tick of a trial is kept in memory
constexpr int64_t kMostTrials = 1000;

constexpr const char* kNameCharacters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

class StudyReader
{
public:
	StudyReader(const JsonSource& source, std::filesystem::path folder, std::string device)
		: m_source(source),
		  m_folder(std::move(folder)),
		  m_device(std::move(device))
	{}

	Result<Study> read(const std::string& path)
	{
		JsonFields root(m_source, m_source.root(), "", m_problem);
		root.need("schema");
		if (root.number("schema", 1, -1e9, 1e9) != 1) root.refuse("schema", "this program reads schema 1");
		m_study.name = root.text("name", std::filesystem::path(path).stem().string());
		if (m_study.name.empty() || m_study.name.size() > 100 || m_study.name.find_first_not_of(kNameCharacters) != std::string::npos)
			root.refuse("name", "names the results: letters, digits, - and _, at most 100");
		root.text("about");
		m_study.seed = static_cast<uint64_t>(root.whole("seed", 1, 0, int64_t(1) << 53));
		m_study.repetitions = static_cast<int>(root.whole("repetitions", 1, 1, kMostTrials));
		m_study.sampleRate = root.number("sampleRate", m_study.sampleRate, 0.1, 1000);
		root.need("timeLimit");
		m_study.timeLimit = root.number("timeLimit", m_study.timeLimit, 1e-3, kLongestTrial);
		m_study.waitLimit = root.number("waitLimit", m_study.waitLimit, 1e-3, kLongestTrial);
		m_study.begin = readEvent(root, "begin");
		m_study.end = readEvent(root, "end");
		root.need("conditions");
		root.eachOf("conditions", [&](JsonFields& f) { readCondition(f); });
		if (m_study.conditions.empty()) root.refuse("conditions", "wants at least one");
		if (m_study.repetitions * static_cast<int64_t>(m_study.conditions.size()) > kMostTrials)
			root.refuse("repetitions", "makes more than " + std::to_string(kMostTrials) + " trials");
		root.finish();
		if (m_problem) return *m_problem;
		return std::move(m_study);
	}

private:
	StudyEvent readEvent(JsonFields& root, const std::string& name)
	{
		StudyEvent event;
		const Json* object = root.object(name);
		if (!object || m_problem) return event;
		JsonFields f(m_source, *object, name, m_problem);
		if (f.has("button") == f.has("contact")) f.refuse("", "wants one of button and contact");
		event.kind = f.has("button") ? StudyEvent::Kind::Button : StudyEvent::Kind::Contact;
		event.button = static_cast<int>(f.whole("button", 1, 1, 32));
		const Json* bodies = f.list("contact");
		for (size_t i = 0; bodies && i < bodies->size() && !m_problem; ++i)
		{
			if (!(*bodies)[i].isText()) f.refuse("contact", "wants the names of bodies, or [] for any body");
			event.bodies.push_back((*bodies)[i].text());
		}
		f.finish();
		return event;
	}

	void readCondition(JsonFields& f)
	{
		StudyCondition condition;
		condition.name = f.newName(m_study.conditions);
		f.need("scene");
		condition.sceneFile = (m_folder / f.text("scene")).lexically_normal().string();
		condition.answer = f.text("answer");
		std::vector<SceneSetting> settings;
		if (const Json* set = f.object("set"))
			for (const auto& [field, value] : set->fields()) settings.push_back({field, value});
		f.finish();  // before the scene is read
		if (m_problem) return;
		Result<Scene> scene = loadScene(condition.sceneFile, settings);
		if (!scene) return f.refuse("", scene.error().message);
		condition.scene = std::move(scene).value();
		checkScene(f, condition);
		if (!m_device.empty() && !m_problem) replaceDevice(f, condition);
		m_study.conditions.push_back(std::move(condition));
	}

	/// Gives the first hand the device of the study, which has no path: where a world begins with its path, that place is lost.
	void replaceDevice(JsonFields& f, StudyCondition& condition)
	{
		SceneHand& first = condition.scene.hands.front();
		if (!first.X_BW && !first.path.empty())
			f.refuse("scene", condition.sceneFile + " does not say where the world of another device is: its first hand wants an origin");
		first.device = m_device;
		first.devicePlace = "--device";
		first.path.clear();
	}

	/// Refuses a scene in which the study could not be run.
	void checkScene(JsonFields& f, const StudyCondition& condition)
	{
		const std::string& file = condition.sceneFile;
		if (condition.scene.hands.empty()) f.refuse("scene", file + " has no hand");
		for (const StudyEvent* event : {&m_study.begin, &m_study.end})
			for (const std::string& name : event->bodies)
				if (!condition.scene.hasBody(name)) f.refuse("scene", "no body of " + file + " is called " + name);
		const std::vector<std::string>& ends = m_study.end.bodies;
		if (!condition.answer.empty() && std::find(ends.begin(), ends.end(), condition.answer) == ends.end())
			f.refuse("answer", condition.answer + " is none of the bodies whose contact ends a trial");
		for (const SceneHook& hook : condition.scene.hooks)
		{
			if (hook.action == SceneHook::Action::Record || hook.action == SceneHook::Action::Stop)
				f.refuse("scene", "a study keeps samples and ends trials by itself; " + file + " has a hook that does");
			const bool switches = hook.action == SceneHook::Action::Switch && hook.what == SceneHook::What::Forces;
			if (switches && hook.hand.value_or(0) == 0 && m_study.begin.kind == StudyEvent::Kind::Button)
				f.refuse("scene", "a study that begins with a button switches the forces by itself; " + file + " has a hook that does");
		}
	}

	const JsonSource& m_source;
	std::filesystem::path m_folder;
	std::string m_device;  // empty: that of each scene
	std::optional<Error> m_problem;
	Study m_study;
};
}  // namespace

Result<Study> parseStudy(const std::string& name, const std::string& text, const std::string& folder, const std::string& device)
{
	const Result<JsonSource> source = JsonSource::parse(name, text);
	if (!source) return source.error();
	return StudyReader(source.value(), folder, device).read(name);
}

Result<Study> loadStudy(const std::string& path, const std::string& device)
{
	const Result<JsonSource> source = JsonSource::load(path);
	if (!source) return source.error();
	return StudyReader(source.value(), std::filesystem::path(path).parent_path(), device).read(path);
}
}  // namespace scenes
