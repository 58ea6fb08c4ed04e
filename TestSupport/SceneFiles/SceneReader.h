// SPDX-License-Identifier: Zlib
#pragma once

#include "TestSupport/SceneFiles/JsonSource.h"
#include "TestSupport/SceneFiles/SceneFile.h"

#include <optional>
#include <string>
#include <vector>

namespace scenes
{
constexpr double kLargestLength = 1000;   // [m]
constexpr double kSmallestLength = 1e-5;  // [m]
constexpr double kLongestRun = 3600;      // [s]
constexpr int kMostButtons = 32;

/// Reads the JSON text of one scene. The first error is kept. Hands and hooks have files of their own.
class SceneReader
{
public:
	SceneReader(const JsonSource& source, std::string folder) : m_source(source), m_folder(std::move(folder)) {}

	ist::Result<Scene> read(const std::string& name);

private:
	JsonFields fields(const ist::JsonValue& object, const std::string& path) { return JsonFields(m_source, object, path, m_problem); }

	/// Index of a name among the objects read so far.
	template <class Named>
	size_t find(JsonFields& f, const std::string& field, const std::string& wanted, const std::vector<Named>& all, const char* kind)
	{
		std::string known;
		for (size_t i = 0; i < all.size(); ++i)
		{
			if (all[i].name == wanted) return i;
			known += (i ? ", " : "") + all[i].name;
		}
		f.refuse(field, std::string("no ") + kind + " is called " + wanted + (known.empty() ? "; there is none" : "; there are " + known));
		return 0;
	}

	std::string placeOf(const JsonFields& f, const std::string& name = {}) const;
	std::string fileName(const std::string& name) const;
	ist::Pose readPose(JsonFields& f);
	double length(JsonFields& f, const std::string& name, double otherwise);

	void readThreads(JsonFields& root);
	void readAsset(JsonFields& f);
	ist::Mesh readShape(JsonFields& f);
	ist::Mesh readCrown(JsonFields& f);
	ist::Mesh readTube(JsonFields& f);
	void readMaterial(JsonFields& f);
	void readBody(JsonFields& f);
	void readStockShape(JsonFields& f, SceneBody& body);
	void readWatch(JsonFields& root);
	void readPair(JsonFields& root, const std::string& at, const ist::JsonValue& pair);

	void readHands(JsonFields& root);
	void readHand(JsonFields& f);
	void readTool(JsonFields& f, SceneHand& hand);
	void readParts(JsonFields& f, SceneHand& hand);
	void readCoupling(JsonFields f, SceneCoupling& coupling);
	void readKeyFrame(JsonFields& f, SceneHand& hand);
	void readHook(JsonFields& f);
	void readSwitch(JsonFields& f, SceneHook& hook);
	void readSwitchedPair(JsonFields& f, SceneHook& hook);
	void checkRecording(JsonFields& f, const std::string& file);

	const JsonSource& m_source;
	std::string m_folder;
	std::optional<ist::Error> m_problem;
	std::vector<SceneMaterial> m_materials;
	Scene m_scene;
};
}  // namespace scenes
