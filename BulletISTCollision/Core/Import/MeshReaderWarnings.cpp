// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshReaderWarnings.h"

#include <assimp/DefaultLogger.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/NullLogger.hpp>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <string_view>

namespace ist
{
namespace
{
/// Messages of the innermost listener.
thread_local std::vector<std::string>* t_heard = nullptr;

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

void hear(const char* message)
{
	if (!t_heard || !message || !isOfFaces(message)) return;
	std::string text = message;
	// The program's own log passes messages on in the form "Warn,  T0: ...\n".
	if (const std::size_t head = text.find(": "); text.starts_with("Warn,") || text.starts_with("Error,")) text.erase(0, head + 2);
	while (!text.empty() && (std::isspace(static_cast<unsigned char>(text.back())) || text.back() == '.')) text.pop_back();
	if (std::find(t_heard->begin(), t_heard->end(), text) == t_heard->end()) t_heard->push_back(text);
}

/// Stream for a log that the program has installed.
class Stream : public Assimp::LogStream
{
public:
	void write(const char* message) override { hear(message); }
};

/// Log for a program that has none.
class Log : public Assimp::Logger
{
public:
	bool attachStream(Assimp::LogStream*, unsigned) override { return false; }
	bool detachStream(Assimp::LogStream*, unsigned) override { return false; }

protected:
	void OnDebug(const char*) override {}
	void OnVerboseDebug(const char*) override {}
	void OnInfo(const char*) override {}
	void OnWarn(const char* message) override { hear(message); }
	void OnError(const char* message) override { hear(message); }
};

/// State that all listeners share. The program may install another log meanwhile; this deletes the former log with its streams.
class Tap
{
public:
	void open()
	{
		const std::lock_guard lock(m_mutex);
		if (m_listeners++ > 0) return;
		if (Assimp::DefaultLogger::isNullLogger())
		{
			m_log = new Log;
			Assimp::DefaultLogger::set(m_log);
			return;
		}
		auto stream = std::make_unique<Stream>();
		if (Assimp::DefaultLogger::get()->attachStream(stream.get(), kSeverity)) m_stream = stream.release();
	}
	void close()
	{
		const std::lock_guard lock(m_mutex);
		if (--m_listeners > 0) return;
		if (m_log && Assimp::DefaultLogger::get() == m_log) Assimp::DefaultLogger::set(nullptr);
		if (m_stream && Assimp::DefaultLogger::get()->detachStream(m_stream, kSeverity)) delete m_stream;
		m_log = nullptr;
		m_stream = nullptr;
	}

private:
	static constexpr unsigned kSeverity = Assimp::Logger::Warn | Assimp::Logger::Err;
	std::mutex m_mutex;
	int m_listeners = 0;
	Assimp::Logger* m_log = nullptr;        // owned by assimp
	Assimp::LogStream* m_stream = nullptr;  // owned by the program's log
};

Tap& tap()
{
	static Tap one;
	return one;
}
}  // namespace

MeshReaderWarnings::MeshReaderWarnings() : m_outer(t_heard)
{
	tap().open();
	t_heard = &m_ofFaces;
}

MeshReaderWarnings::~MeshReaderWarnings()
{
	t_heard = m_outer;
	tap().close();
}
}  // namespace ist
