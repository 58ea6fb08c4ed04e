// SPDX-License-Identifier: Zlib
#include "TestSupport/SceneFiles/JsonSource.h"

#include <algorithm>
#include <cmath>
#include <utility>

using ist::Error;
using ist::Vec3;
using Json = nlohmann::json;

namespace scenes
{
namespace
{
constexpr int kDeepest = 32;

int lineAt(const std::string& text, size_t offset)
{
	return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size())), '\n'));
}

/// Walks over text that is known to be JSON, and records the line of every value.
class Places
{
public:
	/// Skips a byte order mark, as the parser does.
	explicit Places(const std::string& text) : m_text(text), m_at(text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0) {}

	void value(const std::string& path, int depth)
	{
		skip();
		lines[path] = m_line;
		if (depth > kDeepest) problem = "is nested too deeply", problemAt = path;
		if (!problem.empty()) return;
		if (m_text[m_at] == '{') object(path, depth);
		else if (m_text[m_at] == '[') array(path, depth);
		else if (m_text[m_at] == '"') string();
		else
			while (m_at < m_text.size() && std::string(",]} \t\r\n").find(m_text[m_at]) == std::string::npos) ++m_at;
	}

	std::map<std::string, int> lines;
	std::string problem, problemAt;

private:
	void skip()
	{
		for (; m_at < m_text.size() && std::string(" \t\r\n").find(m_text[m_at]) != std::string::npos; ++m_at)
			m_line += m_text[m_at] == '\n';
	}

	std::string string()
	{
		const size_t begin = m_at++;
		for (; m_text[m_at] != '"'; ++m_at) m_at += m_text[m_at] == '\\';
		++m_at;
		return Json::parse(m_text.substr(begin, m_at - begin)).get<std::string>();
	}

	/// Moves behind the bracket or the comma. Returns false after the last member.
	bool next(char end)
	{
		++m_at;
		skip();
		if (m_text[m_at] != end) return true;
		++m_at;
		return false;
	}

	void object(const std::string& path, int depth)
	{
		if (!next('}')) return;
		for (;;)
		{
			skip();
			const int line = m_line;
			const std::string name = string(), full = path.empty() ? name : path + "." + name;
			skip();
			++m_at;
			if (lines.count(full) && problem.empty()) problem = "stands there twice", problemAt = full;
			value(full, depth + 1);
			lines[full] = line;
			if (!problem.empty()) return;
			skip();
			if (m_text[m_at] != ',') break;
			++m_at;
		}
		++m_at;
	}

	void array(const std::string& path, int depth)
	{
		if (!next(']')) return;
		for (int i = 0;; ++i)
		{
			value(path + "[" + std::to_string(i) + "]", depth + 1);
			if (!problem.empty()) return;
			skip();
			if (m_text[m_at] != ',') break;
			++m_at;
		}
		++m_at;
	}

	const std::string& m_text;
	size_t m_at;
	int m_line = 1;
};

/// Offset of what the parser stumbled over. A number that is too large comes without its place but with its text in quotes.
size_t placeOf(const Json::exception& e, const std::string& text)
{
	if (const auto* parsing = dynamic_cast<const Json::parse_error*>(&e)) return parsing->byte > 0 ? parsing->byte - 1 : 0;
	const std::string message = e.what();
	const size_t first = message.find('\''), last = message.rfind('\'');
	if (first == std::string::npos || last <= first) return 0;
	const size_t at = text.find(message.substr(first + 1, last - first - 1));
	return at == std::string::npos ? 0 : at;
}

/// The parser's own words without its number.
std::string complaintOf(const Json::exception& e)
{
	const std::string message = e.what();
	const size_t end = message.find("] ");
	return end == std::string::npos ? message : message.substr(end + 2);
}
}  // namespace

ist::Result<JsonSource> JsonSource::parse(const std::string& name, const std::string& text)
{
	JsonSource source;
	source.m_name = name;
	try
	{
		source.m_root = Json::parse(text);
		Places places(text);
		places.value("", 0);
		source.m_lines = std::move(places.lines);
		if (!places.problem.empty()) return source.problem(places.problemAt, places.problem);
	}
	catch (const Json::exception& e)
	{
		return Error{name + ":" + std::to_string(lineAt(text, placeOf(e, text))) + ": not JSON: " + complaintOf(e)};
	}
	return source;
}

Error JsonSource::problem(const std::string& path, const std::string& problem) const
{
	std::string at = path;
	while (!m_lines.count(at))
	{
		const size_t end = at.find_last_of(".[");
		at = end == std::string::npos ? "" : at.substr(0, end);
	}
	return Error{m_name + ":" + std::to_string(m_lines.at(at)) + ": " + (path.empty() ? "" : path + ": ") + problem};
}

JsonFields::JsonFields(const JsonSource& source, const Json& object, std::string path, std::optional<Error>& problem)
	: m_source(source),
	  m_object(object),
	  m_path(std::move(path)),
	  m_problem(problem)
{
	if (!m_object.is_object()) refuse("", "wants an object in braces");
}

void JsonFields::refuse(const std::string& name, const std::string& problem)
{
	if (!m_problem) m_problem = m_source.problem(pathOf(name), problem);
}

const Json* JsonFields::find(const std::string& name)
{
	m_known.insert(name);
	if (m_problem || !m_object.is_object()) return nullptr;
	const auto at = m_object.find(name);
	return at == m_object.end() ? nullptr : &*at;
}

bool JsonFields::has(const std::string& name) { return find(name) != nullptr; }

void JsonFields::need(const std::string& name)
{
	if (!m_problem && !has(name)) refuse(name, "is missing");
}

double JsonFields::number(const std::string& name, double otherwise, double least, double most)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	const auto shown = [](double v) { return Json(v).dump(); };
	const double found = value->is_number() ? value->get<double>() : std::nan("");
	if (found >= least && found <= most) return found;
	refuse(name, "wants a number from " + shown(least) + " to " + shown(most) + ", not " + value->dump());
	return otherwise;
}

int64_t JsonFields::whole(const std::string& name, int64_t otherwise, int64_t least, int64_t most)
{
	const double found = number(name, static_cast<double>(otherwise), static_cast<double>(least), static_cast<double>(most));
	if (found != std::floor(found)) refuse(name, "wants a whole number");
	return static_cast<int64_t>(found);
}

bool JsonFields::flag(const std::string& name, bool otherwise)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	if (value->is_boolean()) return value->get<bool>();
	refuse(name, "wants true or false, not " + value->dump());
	return otherwise;
}

std::string JsonFields::text(const std::string& name, const std::string& otherwise)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	if (value->is_string() && !value->get<std::string>().empty()) return value->get<std::string>();
	refuse(name, "wants a text in quotes, not " + value->dump());
	return otherwise;
}

int JsonFields::choice(const std::string& name, int otherwise, const std::vector<std::string>& known)
{
	const std::string found = text(name);
	if (found.empty()) return otherwise;
	const auto at = std::find(known.begin(), known.end(), found);
	if (at != known.end()) return static_cast<int>(at - known.begin());
	std::string all;
	for (const std::string& k : known) all += (all.empty() ? "" : ", ") + k;
	refuse(name, "wants one of " + all + ", not " + found);
	return otherwise;
}

Vec3 JsonFields::vector(const std::string& name, const Vec3& otherwise, double largest)
{
	const Json* value = find(name);
	if (!value) return otherwise;
	Vec3 found;
	bool good = value->is_array() && value->size() == 3;
	for (int i = 0; good && i < 3; ++i)
	{
		const Json& entry = (*value)[static_cast<size_t>(i)];
		good = entry.is_number() && std::fabs(entry.get<double>()) <= largest;
		if (good) found[i] = entry.get<double>();
	}
	if (good) return found;
	refuse(name, "wants three numbers of at most " + Json(largest).dump() + " in size, not " + value->dump());
	return otherwise;
}

const Json* JsonFields::list(const std::string& name)
{
	const Json* value = find(name);
	if (!value || value->is_array()) return value;
	refuse(name, "wants a list in brackets");
	return nullptr;
}

const Json* JsonFields::object(const std::string& name)
{
	const Json* value = find(name);
	if (!value || value->is_object()) return value;
	refuse(name, "wants an object in braces");
	return nullptr;
}

void JsonFields::finish()
{
	if (m_problem) return;
	for (const auto& [name, value] : m_object.items())
	{
		if (m_known.count(name)) continue;
		std::string all;
		for (const std::string& k : m_known) all += (all.empty() ? "" : ", ") + k;
		refuse(name, "no such field is known here; known ones are " + all);
		return;
	}
}
}  // namespace scenes
