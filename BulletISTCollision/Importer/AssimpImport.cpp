// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Importer/AssimpImport.h"

#include "BulletISTCollision/Core/Import/Formats/LeftOut.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Importer/MeshReaderWarnings.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/IOStream.hpp>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace ist
{
namespace
{
bool mirrors(const aiMatrix4x4& m) { return aiMatrix3x3(m).Determinant() < 0; }

/// Transforms in double, because assimp's own transform is single precision.
Vec3 transformedPoint(const aiMatrix4x4& m, const aiVector3D& v)
{
	const double x = v.x, y = v.y, z = v.z;
	return {m.a1 * x + m.a2 * y + m.a3 * z + m.a4, m.b1 * x + m.b2 * y + m.b3 * z + m.b4, m.c1 * x + m.c2 * y + m.c3 * z + m.c4};
}

/// Reads in blocks, and reports progress between them. It goes on reading after a cancellation, because assimp's loaders leak memory when
/// a read fails. It throws if a loader reads the file endlessly, as the PLY loader does with a damaged header.
class ProgressStream : public Assimp::IOStream
{
public:
	ProgressStream(Assimp::IOStream* stream, ImportProgress& importProgress) : m_stream(stream), m_progress(importProgress) {}
	size_t Read(void* buffer, size_t size, size_t count) override
	{
		constexpr size_t kBlock = size_t(1) << 24;
		const size_t atOnce = std::max<size_t>(1, kBlock / std::max<size_t>(1, size));
		size_t done = 0;
		while (done < count)
		{
			const size_t wanted = std::min(atOnce, count - done),
						 read = m_stream->Read(static_cast<char*>(buffer) + done * size, size, wanted);
			done += read;
			m_taken += 1 + read * size;
			if (m_taken > kMostTimes * m_stream->FileSize() + kAtLeast)
				throw std::runtime_error("it is damaged: assimp finds no end in it");
			const auto total = static_cast<double>(std::max<size_t>(1, m_stream->FileSize()));
			m_progress.reach(kReading * static_cast<double>(m_stream->Tell()) / total);
			if (read < wanted) break;
		}
		return done;
	}
	size_t Write(const void*, size_t, size_t) override { return 0; }
	aiReturn Seek(size_t offset, aiOrigin origin) override { return m_stream->Seek(offset, origin); }
	size_t Tell() const override { return m_stream->Tell(); }
	size_t FileSize() const override { return m_stream->FileSize(); }
	void Flush() override {}

private:
	// Limit of the bytes read, as a multiple of the file's size: a loader reads a file once, or a few times.
	static constexpr size_t kMostTimes = 16, kAtLeast = size_t(1) << 20;
	std::unique_ptr<Assimp::IOStream> m_stream;
	ImportProgress& m_progress;
	size_t m_taken = 0;
};

class ProgressFiles : public Assimp::DefaultIOSystem
{
public:
	/// `content`, if present, replaces that of the file at `path`; it must outlive this object.
	ProgressFiles(
		ImportProgress& importProgress, const std::string& path, const std::optional<std::string>& content, const FileOpened& opened)
		: m_progress(importProgress),
		  m_path(path),
		  m_content(content),
		  m_opened(opened),
		  m_known{path}
	{}
	Assimp::IOStream* Open(const char* file, const char* mode) override
	{
		const bool isReplaced = m_content && m_path == file;
		Assimp::IOStream* stream = isReplaced
			? new Assimp::MemoryIOStream(reinterpret_cast<const uint8_t*>(m_content->data()), m_content->size())
			: DefaultIOSystem::Open(file, mode);
		if (!stream) return nullptr;
		if (m_opened && m_known.insert(file).second) m_opened(static_cast<double>(stream->FileSize()));
		return new ProgressStream(stream, m_progress);
	}
	void Close(Assimp::IOStream* stream) override { delete stream; }

private:
	ImportProgress& m_progress;
	const std::string& m_path;
	const std::optional<std::string>& m_content;
	const FileOpened& m_opened;
	std::set<std::string> m_known;  ///< files whose size was told
};

double blur(const aiMesh& part)
{
	if (part.mNumVertices == 0) return 0;
	const aiVector3D& first = part.mVertices[0];
	Box box{{first.x, first.y, first.z}, {first.x, first.y, first.z}};
	for (unsigned i = 0; i < part.mNumVertices; ++i)
		for (int axis = 0; axis < 3; ++axis)
		{
			box.lower[axis] = std::min<double>(box.lower[axis], part.mVertices[i][unsigned(axis)]);
			box.upper[axis] = std::max<double>(box.upper[axis], part.mVertices[i][unsigned(axis)]);
		}
	return blur(box);
}

/// Distance between neighbouring single-precision values at the coordinates that a vertex and its transform consist of [units of the
/// file].
struct Rounding
{
	double inPart = 0;        ///< without the part's translation, which is the same for all of its corners
	double betweenParts = 0;  ///< with the part's translation
};

void include(Rounding& rounding, const aiMatrix4x4& m, const aiVector3D& v)
{
	const auto add = [&](double a, double b, double c, double d) {
		const double sum = std::fabs(a * v.x) + std::fabs(b * v.y) + std::fabs(c * v.z);
		rounding.inPart = std::max(rounding.inPart, 0x1p-23 * sum);
		rounding.betweenParts = std::max(rounding.betweenParts, 0x1p-23 * (sum + std::fabs(d)));
	};
	add(m.a1, m.a2, m.a3, m.a4);
	add(m.b1, m.b2, m.b3, m.b4);
	add(m.c1, m.c2, m.c3, m.c4);
}

/// Removes elements that are not faces, and faces with invalid corners: assimp does not check them, and triangulating them reads beyond
/// the vertices. The part's primitive types are set to those that remain. Otherwise assimp ends the process if it expects polygons and
/// finds none.
void removeInvalidFaces(aiMesh& part, LeftOut& out)
{
	unsigned kept = 0, kinds = part.mPrimitiveTypes & aiPrimitiveType_NGONEncodingFlag;
	for (unsigned i = 0; i < part.mNumFaces; ++i)
	{
		aiFace& face = part.mFaces[i];
		const bool isValid = std::all_of(
			face.mIndices, face.mIndices + face.mNumIndices, [&](unsigned corner) { return corner < part.mNumVertices; });
		if (!out.takes(face.mNumIndices, isValid)) continue;
		kinds |= AI_PRIMITIVE_TYPE_FOR_N_INDICES(face.mNumIndices);
		std::swap(part.mFaces[kept].mNumIndices, face.mNumIndices);
		std::swap(part.mFaces[kept++].mIndices, face.mIndices);
	}
	part.mNumFaces = kept;
	part.mPrimitiveTypes = kinds;
}

std::span<aiMesh* const> partsOf(const aiScene& scene) { return {scene.mMeshes, scene.mNumMeshes}; }

LeftOut removeInvalidFaces(const aiScene& scene)
{
	LeftOut out;
	for (aiMesh* part : partsOf(scene)) removeInvalidFaces(*part, out);
	return out;
}

/// Name of the reader that read the last file.
std::string_view readerName(const Assimp::Importer& importer)
{
	const aiImporterDesc* reader = importer.GetImporterInfo(static_cast<size_t>(importer.GetPropertyInteger("importerIndex", -1)));
	return reader ? reader->mName : "";
}

/// What assimp says about faces of damaged files.
std::vector<std::string> sentences(const std::vector<std::string>& warnings)
{
	std::vector<std::string> all;
	for (const std::string& warning : warnings)
		all.push_back("The reader left faces out, or gave them other corners, because the file is damaged (\"" + warning +
			"\"); export the mesh again.");
	return all;
}

/// Texture coordinates of a corner; NaN if the file has none.
TexturePlace placeOf(const aiMesh& part, uint32_t corner)
{
	if (!part.HasTextureCoords(0)) return {std::nan(""), std::nan("")};
	const aiVector3D& place = part.mTextureCoords[0][corner];
	return {place.x, place.y};
}

void append(TexturedMesh& textured, Rounding& rounding, const aiMesh& part, const aiMatrix4x4& transform, double unit, Wanted wanted)
{
	Mesh& out = textured.mesh;
	const auto base = static_cast<uint32_t>(out.vertices.size());
	for (unsigned i = 0; i < part.mNumVertices; ++i)
	{
		out.vertices.push_back(unit * transformedPoint(transform, part.mVertices[i]));
		include(rounding, transform, part.mVertices[i]);
	}
	const bool mirrored = mirrors(transform);
	for (unsigned i = 0; i < part.mNumFaces; ++i)
	{
		const aiFace& face = part.mFaces[i];
		if (face.mNumIndices != 3) continue;
		uint32_t a = face.mIndices[0], b = face.mIndices[1], c = face.mIndices[2];
		if (mirrored) std::swap(b, c);
		out.triangles.push_back({base + a, base + b, base + c});
		if (wanted == Wanted::SurfaceAndPlaces) textured.places.push_back({placeOf(part, a), placeOf(part, b), placeOf(part, c)});
	}
}

/// The rounding as a share of the mesh's longest side, from lengths in units of the file. Parts whose rounding exceeds the allowed blur
/// are not welded to each other.
double share(const Rounding& rounding, bool inOnePlace, double side)
{
	const double between = rounding.betweenParts / side;
	return inOnePlace || between > kBlurred ? rounding.inPart / side : between;
}

TexturedMesh gather(const aiScene& scene, double unit, Wanted wanted, ImportProgress& importProgress)
{
	TexturedMesh textured;
	Rounding rounding;
	std::optional<Vec3> place;
	bool inOnePlace = true;
	int missing = 0;
	std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene.mRootNode, aiMatrix4x4()}};
	for (size_t done = 1; !open.empty() && importProgress.reach(kReading + (1 - kReading) * double(done) / double(done + open.size()));
		 ++done)
	{
		const auto [node, parentTransform] = open.back();
		open.pop_back();
		const aiMatrix4x4 transform = parentTransform * node->mTransformation;
		for (unsigned i = 0; i < node->mNumMeshes; ++i)
		{
			const aiMesh* part = scene.mMeshes[node->mMeshes[i]];
			if (!(part->mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) continue;
			append(textured, rounding, *part, transform, unit, wanted);
			const Vec3 here{transform.a4, transform.b4, transform.c4};
			inOnePlace = inOnePlace && here == place.value_or(here);
			place = here;
		}
		for (unsigned i = node->mNumChildren; i-- > 0;)
			if (const aiNode* child = node->mChildren[i]) open.emplace_back(child, transform);
			else ++missing;  // RAW files with a group that has no triangle
	}
	if (const double side = bounds(textured.mesh).longestSide(); side > 0)
		textured.mesh.rounding = std::max(textured.mesh.rounding, share(rounding, inOnePlace, side / unit));
	if (missing > 0)
		textured.mesh.notTaken.push_back("Parts of the file in which the reader found no triangle: " + std::to_string(missing) +
			"; if they are damaged, export the mesh again.");
	return textured;
}

std::optional<Error> checkPlaces(const TexturedMesh& textured, const aiScene& scene, const std::string& path)
{
	const std::span<aiMesh* const> parts = partsOf(scene);
	for (std::size_t i = 0; i < parts.size(); ++i)
		if ((parts[i]->mPrimitiveTypes & aiPrimitiveType_TRIANGLE) && !parts[i]->HasTextureCoords(0))
			return Error{path + ": part " + std::to_string(i + 1) + " of " + std::to_string(parts.size()) +
				" has no texture coordinates; " + kUnwrap};
	return notFinitePlace(textured, path);
}

/// Throws std::bad_alloc if that is why assimp read no scene.
void throwIfOutOfMemory(const Assimp::Importer& importer)
{
	if (!importer.GetException()) return;
	try
	{
		std::rethrow_exception(importer.GetException());
	}
	catch (const std::bad_alloc&)
	{
		throw;
	}
	catch (...)
	{}  // reasonOf() has its message
}

/// Assimp's error message without the full stop.
std::string reasonOf(const Assimp::Importer& importer)
{
	std::string reason = importer.GetErrorString();
	while (!reason.empty() && (reason.back() == '.' || reason.back() == ';' || reason.back() == ' ')) reason.pop_back();
	return reason.empty() ? "assimp does not say why" : reason;
}

/// FBX files state centimetres per unit. Many are in metres all the same, so the reader's coordinates are not scaled.
std::optional<std::string> unitOfFbx(const aiScene& scene, const Assimp::Importer& importer, const std::optional<double>& given)
{
	float centimetres = 0;
	if (given || readerName(importer) != "Autodesk FBX Importer" || !scene.mMetaData ||
		!scene.mMetaData->Get("UnitScaleFactor", centimetres))
		return std::nullopt;
	if (!(centimetres > 0) || centimetres == 100) return std::nullopt;
	const std::string metres = lengthWords(0.01 * double(centimetres));
	return "The file states " + metres +
		" as its unit, which is not applied to FBX files: its coordinates were taken as metres; pass its unit to importMesh() if they "
		"are not.";
}

Result<TexturedMesh> read(
	const std::string& path, const std::optional<double>& given, Wanted wanted, ImportProgress& importProgress, const FileOpened& opened)
{
	const Result<MeshFileHead> head = readMeshFileHead(path);
	if (!head) return head.error();
	const Result<Scale> scale = scaleOf(path, head.value().unit, given);
	if (!scale) return scale.error();
	Assimp::Importer importer;
	// Otherwise the reader would turn the file's up axis to y, and a COLLADA file would lie across its own STL twin.
	importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
	importer.SetIOHandler(new ProgressFiles(importProgress, path, head.value().content, opened));
	const MeshReaderWarnings warnings;
	const aiScene* scene = importer.ReadFile(path, 0);
	const LeftOut leftOut = scene ? removeInvalidFaces(*scene) : LeftOut();
	if (const auto sentence = leftOut.tooDamaged()) return Error{path + ": " + *sentence};
	if (scene) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
	if (importProgress.cancelled()) return importCancelled();
	if (!scene) throwIfOutOfMemory(importer);
	if (!scene || !scene->mRootNode)
		return Error{"cannot read " + path + ": " + reasonOf(importer) +
			"; the file may be cut short, of a format that assimp does not know, or of another one than its name ends with: export it "
			"again"};
	TexturedMesh textured = gather(*scene, scale.value().factor, wanted, importProgress);
	textured.mesh.unit = scale.value().unit;
	if (importProgress.cancelled()) return importCancelled();
	double worst = 0;
	for (const aiMesh* part : partsOf(*scene)) worst = std::max(worst, blur(*part));
	if (const auto error = whyUnusable(textured.mesh, path, worst)) return *error;
	if (wanted == Wanted::SurfaceAndPlaces)
		if (auto error = checkPlaces(textured, *scene, path)) return *error;
	for (std::string& sentence : leftOut.sentences()) textured.mesh.notTaken.push_back(std::move(sentence));
	for (std::string& sentence : sentences(warnings.ofFaces())) textured.mesh.notTaken.push_back(std::move(sentence));
	if (auto sentence = given ? scale.value().notTaken : unitOfFbx(*scene, importer, given))
		textured.mesh.notTaken.push_back(*std::move(sentence));
	return textured;
}
}  // namespace

Result<TexturedMesh> importByAssimp(
	const std::string& path, std::optional<double> unit, Wanted wanted, const Progress& progress, const FileOpened& opened)
{
	ImportProgress importProgress(progress);
	try
	{
		return read(path, unit, wanted, importProgress, opened);
	}
	catch (const std::bad_alloc&)
	{
		throw;
	}
	catch (const std::exception& exception)
	{
		return Error{"cannot read " + path + ": " + exception.what() + "; export the mesh again"};
	}
}
}  // namespace ist
