// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Base/Vec3.h"
#include "BulletISTCollision/Json/JsonValue.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace scenes
{
/// JSON text whose values know their lines. A path has the form `bodies[2].mass`; the path of the whole text is empty.
class JsonSource
{
public:
	/// Parses a text. Refused, with name and line: text that is not JSON, an object with the same field twice, and nesting beyond 32
	/// levels.
	static ist::Result<JsonSource> parse(const std::string& name, const std::string& text);
	/// Reads and parses a file, whose path is the name.
	static ist::Result<JsonSource> load(const std::string& path);

	const ist::JsonValue& root() const { return m_root; }
	/// Replaces the value at a path, or adds a field that is not there. Returns why not: a path that is not of the form above, an element
	/// that the list lacks, a field of what is no object. Problems of the new value have the line of the old one.
	std::optional<ist::Error> replace(const std::string& path, ist::JsonValue value);
	/// `NAME:14: bodies[2].mass: PROBLEM`; of a path that is not there, the line of the innermost one that is.
	ist::Error problem(const std::string& path, const std::string& problem) const;

private:
	std::string m_name;
	ist::JsonValue m_root;
	std::map<std::string, int> m_lines;
};

/// Reads the fields of one object. The first error is kept for all readers of a file; every later field is read as its default.
class JsonFields
{
public:
	JsonFields(const JsonSource& source, const ist::JsonValue& object, std::string path, std::optional<ist::Error>& problem);

	bool has(const std::string& name);
	double number(const std::string& name, double otherwise, double least, double most);
	int64_t whole(const std::string& name, int64_t otherwise, int64_t least, int64_t most);
	bool flag(const std::string& name, bool otherwise);
	std::string text(const std::string& name, const std::string& otherwise = {});
	/// Reads a text that must be one of `known`, and returns its index there.
	int choice(const std::string& name, int otherwise, const std::vector<std::string>& known);
	ist::Vec3 vector(const std::string& name, const ist::Vec3& otherwise, double largest);
	/// Null where it is missing or something else.
	const ist::JsonValue* list(const std::string& name);
	const ist::JsonValue* object(const std::string& name);
	/// Reads every object of a list, and refuses unknown fields in each.
	template <class Read> void eachOf(const std::string& name, const Read& read)
	{
		const ist::JsonValue* all = list(name);
		for (size_t i = 0; all && i < all->size() && !m_problem; ++i)
		{
			JsonFields each(m_source, (*all)[i], pathOf(name) + "[" + std::to_string(i) + "]", m_problem);
			read(each);
			each.finish();
		}
	}
	/// Reads the field `name`, which must be there, and refuses a name that one of `all` has.
	template <class Named> std::string newName(const std::vector<Named>& all)
	{
		need("name");
		const std::string name = text("name");
		for (const Named& other : all)
			if (other.name == name) refuse("name", "another one is called " + name + " already");
		return name;
	}
	void need(const std::string& name);
	void refuse(const std::string& name, const std::string& problem);
	/// Refuses every field of the object that was not read.
	void finish();

	std::string pathOf(const std::string& name) const { return m_path.empty() ? name : name.empty() ? m_path : m_path + "." + name; }
	const JsonSource& source() const { return m_source; }
	std::optional<ist::Error>& problem() { return m_problem; }

private:
	const ist::JsonValue* find(const std::string& name);

	const JsonSource& m_source;
	const ist::JsonValue& m_object;
	std::string m_path;
	std::optional<ist::Error>& m_problem;
	std::set<std::string> m_known;
};
}  // namespace scenes
