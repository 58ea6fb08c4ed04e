// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/PackageModel.h"

#include "BulletISTCollision/Core/Import/Formats/ImportCancelled.h"
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace ist
{
namespace
{
constexpr std::string_view kBlanks = " \t\r\n";
/// Tags between two calls of the progress function.
constexpr size_t kTagsAtOnce = 1 << 16;

/// Reads the tags of one model part. Elements are told by their names and depths, because extensions have elements of the same names.
class PackageReader
{
public:
	PackageReader(std::string_view text, const std::function<bool(double)>& progress)
		: m_tags(text),
		  m_size(text.size()),
		  m_progress(progress)
	{}
	Result<PackageModel> read();

private:
	void take();
	void takeObject();
	void takeInObject();
	void takeVertex();
	void takeTriangle();
	void takePlaces(PackageObject& object, size_t triangle);
	PackageInstance instance();
	PackageTransform transform();
	double coordinate(const char* name);
	uint32_t index(const char* name);
	/// The index that an attribute states, if it is there.
	std::optional<uint32_t> indexIfAny(const char* name);
	void refuse(const std::string& problem)
	{
		if (m_problem.empty()) m_problem = problem;
	}
	std::string element() const { return "an element \"" + std::string(m_tags.name()) + "\" of object " + quotedText(m_id); }

	XmlTags m_tags;
	size_t m_size;
	const std::function<bool(double)>& m_progress;
	PackageModel m_model;
	std::string m_section;              ///< element of depth 2: "resources" or "build"
	std::string m_id;                   ///< that of the object or group of texture coordinates which is read
	PackageObject* m_object = nullptr;  ///< the object that is read
	PackageObject m_unused;             ///< takes what an object has whose id is there already
	std::vector<TexturePlace>* m_group = nullptr;
	std::map<std::string, std::vector<TexturePlace>> m_groups;
	std::string m_groupOfObject;
	std::optional<uint32_t> m_placeOfObject;
	std::string m_problem;
};

Result<PackageModel> PackageReader::read()
{
	if (!m_tags.next() || m_tags.name() != "model") return Error{"its model is no XML with the element \"model\"; export it again"};
	m_model.unit = m_tags.attribute("unit");
	for (size_t count = 1; m_problem.empty() && m_tags.next(); ++count)
	{
		take();
		if (count % kTagsAtOnce == 0 && m_progress && !m_progress(double(m_tags.position()) / double(m_size))) return importCancelled();
	}
	if (!m_problem.empty()) return Error{m_problem + "; export it again"};
	if (!m_tags.isWhole()) return Error{"its model is cut short, or no whole XML; export it again"};
	return std::move(m_model);
}

void PackageReader::take()
{
	const std::string_view name = m_tags.name();
	const int depth = m_tags.depth();
	if (depth == 2) m_section = name;
	if (depth <= 3) m_object = nullptr, m_group = nullptr;
	if (depth == 3 && m_section == "resources") takeObject();
	else if (depth == 3 && m_section == "build" && name == "item") m_model.build.push_back(instance());
	else if (m_object) takeInObject();
	else if (m_group && depth == 4 && name == "tex2coord") m_group->push_back({coordinate("u"), coordinate("v")});
}

void PackageReader::takeObject()
{
	m_id = m_tags.attribute("id").value_or("");
	if (m_tags.name() == "texture2dgroup") m_group = &m_groups[m_id];
	if (m_tags.name() != "object") return;
	const auto [object, isNew] = m_model.objects.try_emplace(m_id);
	m_object = isNew ? &object->second : &(m_unused = {});
	m_groupOfObject = m_tags.attribute("pid").value_or("");
	m_placeOfObject = indexIfAny("pindex");
}

void PackageReader::takeInObject()
{
	const std::string_view name = m_tags.name();
	if (m_tags.depth() == 5 && name == "component") m_object->components.push_back(instance());
	if (m_tags.depth() == 6 && name == "vertex") m_object->vertices.push_back({coordinate("x"), coordinate("y"), coordinate("z")});
	if (m_tags.depth() == 6 && name == "triangle") takeTriangle();
}

void PackageReader::takeTriangle()
{
	const size_t triangle = m_object->triangles.size();
	m_object->triangles.push_back({index("v1"), index("v2"), index("v3")});
	takePlaces(*m_object, triangle);
}

void PackageReader::takePlaces(PackageObject& object, size_t triangle)
{
	const std::array<TexturePlace, 3> none{{{std::nan(""), std::nan("")}, {std::nan(""), std::nan("")}, {std::nan(""), std::nan("")}}};
	const std::optional<uint32_t> first = indexIfAny("p1");
	const auto group = m_groups.find(m_tags.attribute("pid").value_or(m_groupOfObject));
	std::array<TexturePlace, 3> places = none;
	if (group != m_groups.end() && (first || m_placeOfObject))
	{
		// A triangle without p2 and p3 has p1 at all corners, and one without p1 the object's.
		const uint32_t a = first.value_or(m_placeOfObject.value_or(0));
		const std::array<uint32_t, 3> corners = {a, first ? indexIfAny("p2").value_or(a) : a, first ? indexIfAny("p3").value_or(a) : a};
		for (size_t i = 0; i < 3; ++i)
			if (corners[i] < group->second.size()) places[i] = group->second[corners[i]];
		object.places.resize(triangle, none);
	}
	if (object.places.size() == triangle && (triangle > 0 || !std::isnan(places[0].u))) object.places.push_back(places);
}

PackageInstance PackageReader::instance()
{
	PackageInstance out;
	out.object = m_tags.attribute("objectid").value_or("");
	out.part = m_tags.prefixedAttribute("path").value_or("");
	out.transform = transform();
	return out;
}

PackageTransform PackageReader::transform()
{
	PackageTransform out;
	const std::optional<std::string> stated = m_tags.attribute("transform");
	if (!stated) return out;
	std::array<double, 12> numbers{};
	size_t count = 0;
	std::string_view rest = *stated;
	for (size_t at = rest.find_first_not_of(kBlanks); at != rest.npos; at = rest.find_first_not_of(kBlanks))
	{
		rest.remove_prefix(at);
		const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
		const std::optional<double> number = numberInText(word);
		if (!number || count == numbers.size()) return refuse("a transform is " + quotedText(*stated) + " and not twelve numbers"), out;
		numbers[count++] = *number;
		rest.remove_prefix(word.size());
	}
	if (count != numbers.size()) return refuse("a transform is " + quotedText(*stated) + " and not twelve numbers"), out;
	// The file has rows of the transposed matrix, the offset last.
	for (size_t row = 0; row < 3; ++row)
		for (size_t column = 0; column < 3; ++column) out.linear.m[row][column] = numbers[3 * column + row];
	out.offset = {numbers[9], numbers[10], numbers[11]};
	return out;
}

double PackageReader::coordinate(const char* name)
{
	const std::optional<std::string> stated = m_tags.attribute(name);
	const std::optional<double> number = stated ? numberInText(*stated) : std::nullopt;
	if (!number) refuse(element() + " has " + (stated ? quotedText(*stated) : "nothing") + " as its " + name);
	return number.value_or(0);
}

std::optional<uint32_t> PackageReader::indexIfAny(const char* name)
{
	const std::optional<std::string> stated = m_tags.attribute(name);
	if (!stated) return std::nullopt;
	uint32_t value = 0;
	const std::from_chars_result end = std::from_chars(stated->data(), stated->data() + stated->size(), value);
	if (end.ec == std::errc() && end.ptr == stated->data() + stated->size()) return value;
	refuse(element() + " has " + quotedText(*stated) + " as its " + name);
	return std::nullopt;
}

uint32_t PackageReader::index(const char* name)
{
	const std::optional<uint32_t> stated = indexIfAny(name);
	if (!stated) refuse(element() + " has no " + name);
	return stated.value_or(0);
}
}  // namespace

Result<PackageModel> readPackageModel(std::string_view text, const std::function<bool(double)>& progress)
{
	return PackageReader(text, progress).read();
}
}  // namespace ist
