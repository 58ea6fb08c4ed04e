// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Importer/MeshReaderWarnings.h"

#include <assimp/DefaultLogger.hpp>
#include <assimp/Logger.hpp>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string_view>

namespace ist
{
namespace
{
bool hasAny(std::string_view text, std::initializer_list<std::string_view> words)
{
	return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return text.find(word) != text.npos; });
}

/// Whether a message is about faces; each reader has its own words. Messages about a face's appearance do not concern its corners.
bool isOfFaces(std::string text)
{
	std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
	return hasAny(text, {"out of range", "out-of-range", "overflow", "invalid", "dropped", "ignor"}) &&
		hasAny(text, {"face", "vertex index", "vertex reference", "indices"}) &&
		!hasAny(text, {"material", "texture", "uv", "normal", "color", "bone", "weight"});
}

/// Passes assimp's messages about faces on.
class Log : public Assimp::Logger
{
public:
	explicit Log(std::vector<std::string>& heard) : m_heard(heard) {}
	bool attachStream(Assimp::LogStream*, unsigned) override { return false; }
	bool detachStream(Assimp::LogStream*, unsigned) override { return false; }

protected:
	void OnDebug(const char*) override {}
	void OnVerboseDebug(const char*) override {}
	void OnInfo(const char*) override {}
	void OnWarn(const char* message) override { hear(message); }
	void OnError(const char* message) override { hear(message); }

private:
	void hear(std::string text)
	{
		if (!isOfFaces(text)) return;
		while (!text.empty() && (std::isspace(static_cast<unsigned char>(text.back())) || text.back() == '.')) text.pop_back();
		if (std::find(m_heard.begin(), m_heard.end(), text) == m_heard.end()) m_heard.push_back(text);
	}
	std::vector<std::string>& m_heard;
};
}  // namespace

// Assimp owns its log, and deletes it when it gets another.
MeshReaderWarnings::MeshReaderWarnings() { Assimp::DefaultLogger::set(new Log(m_ofFaces)); }

MeshReaderWarnings::~MeshReaderWarnings() { Assimp::DefaultLogger::set(nullptr); }
}  // namespace ist
