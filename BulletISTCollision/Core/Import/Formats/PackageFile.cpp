// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/PackageFile.h"

#include "BulletISTCollision/Core/Import/Formats/LeftOut.h"
#include "BulletISTCollision/Core/Import/Formats/MeshText.h"
#include "BulletISTCollision/Core/Import/Formats/PackageModel.h"
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"
#include "BulletISTCollision/Core/Import/Formats/ZipArchive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace ist
{
namespace
{
constexpr std::string_view kModelOf3mf = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
/// Objects in objects in objects: real files have two or three levels.
constexpr int kDeepest = 64;
/// A small file can state more triangles than any memory holds, because objects contain objects.
constexpr size_t kMostTriangles = 30'000'000, kMostObjects = 1'000'000;

bool mirrors(const Mat3& m) { return dot(m.row(0), cross(m.row(1), m.row(2))) < 0; }

PackageTransform operator*(const PackageTransform& outer, const PackageTransform& inner)
{
	return {outer.linear * inner.linear, outer.linear * inner.offset + outer.offset};
}

/// Composes the items of a package's build.
class PackageComposer
{
public:
	PackageComposer(const ZipArchive& archive, const std::function<bool(double)>& progress) : m_archive(archive), m_progress(progress) {}
	Result<PackageSurface> compose();

private:
	/// Reads a model part once. Nothing happens if it was read before.
	std::optional<Error> readPart(const std::string& name);
	std::optional<Error> add(const PackageInstance& instance, const std::string& part, const PackageTransform& outer, int depth);
	void addTriangles(const PackageObject& object, const PackageTransform& transform);

	const ZipArchive& m_archive;
	const std::function<bool(double)>& m_progress;
	std::map<std::string, PackageModel> m_parts;
	PackageSurface m_out;
	LeftOut m_leftOut;
	bool m_hasPlaces = true;
	size_t m_objects = 0;
};

std::string rootPart(const ZipArchive& archive)
{
	const std::optional<std::string> relations = archive.read("_rels/.rels");
	if (!relations) return "";
	const std::string text = utf8Text(*relations);
	for (XmlTags tags(text); tags.next();)
		if (tags.name() == "Relationship" && tags.attribute("Type") == kModelOf3mf) return nameInZip(tags.attribute("Target").value_or(""));
	return "";
}

std::optional<Error> PackageComposer::readPart(const std::string& name)
{
	if (m_parts.contains(name)) return std::nullopt;
	const std::optional<std::string> bytes = m_archive.read(name);
	if (!bytes || bytes->empty()) return Error{"its model " + quotedText(name) + " is missing or damaged; export the mesh again"};
	Result<PackageModel> model = readPackageModel(needsUtf8(*bytes) ? utf8Text(*bytes) : *bytes, m_progress);
	if (!model) return model.error();
	m_parts.emplace(name, std::move(model).value());
	return std::nullopt;
}

void PackageComposer::addTriangles(const PackageObject& object, const PackageTransform& transform)
{
	Mesh& mesh = m_out.textured.mesh;
	const auto first = static_cast<uint32_t>(mesh.vertices.size());
	for (const Vec3& v : object.vertices) mesh.vertices.push_back(transform.linear * v + transform.offset);
	const bool mirrored = mirrors(transform.linear);
	m_hasPlaces = m_hasPlaces && object.places.size() == object.triangles.size();
	for (size_t t = 0; t < object.triangles.size(); ++t)
	{
		std::array<uint32_t, 3> corners = object.triangles[t];
		const auto isThere = [&](uint32_t corner) { return corner < object.vertices.size(); };
		if (!m_leftOut.takes(3, std::all_of(corners.begin(), corners.end(), isThere))) continue;
		for (uint32_t& corner : corners) corner += first;
		if (mirrored) std::swap(corners[1], corners[2]);
		mesh.triangles.push_back(corners);
		if (!m_hasPlaces) continue;
		m_out.textured.places.push_back(object.places[t]);
		if (mirrored) std::swap(m_out.textured.places.back()[1], m_out.textured.places.back()[2]);
	}
}

std::optional<Error> PackageComposer::add(
	const PackageInstance& instance, const std::string& part, const PackageTransform& outer, int depth)
{
	if (depth > kDeepest) return Error{"its object " + quotedText(instance.object) + " contains itself; export it again"};
	const std::string place = instance.part.empty() ? part : nameInZip(instance.part);
	if (auto error = readPart(place)) return error;
	const PackageModel& model = m_parts.at(place);
	const auto object = model.objects.find(instance.object);
	if (object == model.objects.end())
		return Error{"it places the object " + quotedText(instance.object) + ", which is not in its model " + quotedText(place) +
			"; export it again"};
	const PackageTransform transform = outer * instance.transform;
	if (++m_objects > kMostObjects || m_out.textured.mesh.triangles.size() + object->second.triangles.size() > kMostTriangles ||
		m_out.textured.mesh.vertices.size() + object->second.vertices.size() > kMostTriangles)
		return Error{"it has more than 30 million triangles, or a million objects; export a part of it"};
	addTriangles(object->second, transform);
	for (const PackageInstance& component : object->second.components)
		if (auto error = add(component, place, transform, depth + 1)) return error;
	return std::nullopt;
}

Result<PackageSurface> PackageComposer::compose()
{
	const std::string root = rootPart(m_archive);
	if (root.empty()) return Error{"it is an archive that names no model, so it is no whole 3MF file; export the mesh again"};
	if (const auto error = readPart(root)) return *error;
	const PackageModel& model = m_parts.at(root);
	if (model.build.empty()) return Error{"its build places no object; export it again"};
	m_out.unit = model.unit;
	for (const PackageInstance& item : model.build)
		if (const auto error = add(item, root, {}, 1)) return *error;
	if (const auto sentence = m_leftOut.tooDamaged()) return Error{*sentence};
	if (!m_hasPlaces) m_out.textured.places.clear();
	m_out.textured.mesh.notTaken = m_leftOut.sentences();
	return std::move(m_out);
}
}  // namespace

Result<PackageSurface> readPackage(std::string_view bytes, const std::function<bool(double)>& progress)
{
	const std::optional<ZipArchive> archive = ZipArchive::open(bytes);
	if (!archive) return Error{"its archive is damaged; export the mesh again"};
	return PackageComposer(*archive, progress).compose();
}
}  // namespace ist
