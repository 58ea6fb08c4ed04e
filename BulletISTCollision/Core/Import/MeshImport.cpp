// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"

#include "BulletISTCollision/Core/Import/Formats/PackageFile.h"
#include "BulletISTCollision/Core/Import/Formats/PlyFile.h"
#include "BulletISTCollision/Core/Import/Formats/StlFile.h"
#include "BulletISTCollision/Core/Import/ImportApart.h"
#include "BulletISTCollision/Core/Import/ImportChecks.h"
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>

namespace ist
{
namespace
{
/// Whether a file is what Git LFS keeps in a repository in place of it.
bool isPointer(const std::string& path)
{
	constexpr std::string_view kBegin = "version https://git-lfs.github.com/spec/";
	char begin[kBegin.size()] = {};
	std::ifstream(systemPath(path), std::ios::binary).read(begin, sizeof begin);
	return std::string_view(begin, sizeof begin) == kBegin;
}

std::optional<Error> whyNoMeshFile(const std::string& path)
{
	std::error_code failure;
	const std::filesystem::file_status status = std::filesystem::status(systemPath(path), failure);
	if (!std::filesystem::exists(status)) return Error{"cannot read " + path + ": there is no such file; check the path"};
	if (std::filesystem::is_directory(status)) return Error{"cannot read " + path + ": it is a folder; name a file in it"};
	if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(systemPath(path), failure) == 0 && !failure)
		return Error{"cannot read " + path + ": it is empty (0 bytes); export the mesh again"};
	if (std::filesystem::is_regular_file(status) && isPointer(path))
		return Error{
			"cannot read " + path + ": it is not the mesh but a pointer to it, as Git LFS leaves in its place; fetch it (git lfs pull)"};
	return std::nullopt;
}

/// Reads the bytes of a file in blocks.
Result<std::string> bytesOf(const std::string& path, ImportProgress& importProgress)
{
	std::ifstream file(systemPath(path), std::ios::binary | std::ios::ate);
	if (!file) return Error{"cannot read " + path + ": it cannot be opened; check its permissions"};
	const std::streamoff size = std::max<std::streamoff>(0, file.tellg());
	file.seekg(0);
	std::string bytes(static_cast<size_t>(size), '\0');
	constexpr std::streamoff kBlock = std::streamoff(1) << 24;
	for (std::streamoff done = 0; done < size; done = std::min(size, done + kBlock))
	{
		if (!file.read(bytes.data() + done, std::min(kBlock, size - done)))
			return Error{"cannot read " + path + ": reading it failed after " + std::to_string(done) + " bytes; copy it again"};
		if (!importProgress.reach(0.5 * kReading * double(done) / double(size))) return importCancelled();
	}
	return bytes;
}

/// Reads a whole file by a reader of ours, which takes bytes and a progress function.
template <class Reader> auto readByOurs(const std::string& path, ImportProgress& importProgress, const Reader& reader)
{
	using Read = decltype(reader(std::string_view(), std::function<bool(double)>()));
	const Result<std::string> bytes = bytesOf(path, importProgress);
	if (!bytes) return Read(bytes.error());
	Read read = reader(bytes.value(), [&](double done) { return importProgress.reach(kReading * (0.5 + 0.5 * done)); });
	if (read || read.error().cancelled) return read;
	return Read(Error{"cannot read " + path + ": " + read.error().message});
}

/// What a reader of ours has read, in metres and checked. `isDouble`: the file has its numbers in double precision.
Result<TexturedMesh> inMetres(TexturedMesh textured, const std::string& path, double unit, bool isDouble, Wanted wanted)
{
	Mesh& mesh = textured.mesh;
	const double worst = isDouble ? 0 : blur(bounds(mesh));
	for (Vec3& v : mesh.vertices) v = unit * v;
	mesh.unit = unit;
	mesh.rounding = std::max(mesh.rounding, worst);
	if (const auto error = whyUnusable(mesh, path, worst)) return *error;
	if (wanted == Wanted::Surface) textured.places.clear();
	else if (textured.places.empty()) return Error{path + " has no texture coordinates; " + kUnwrap};
	else if (auto error = notFinitePlace(textured, path)) return *error;
	return textured;
}

Result<TexturedMesh> readStlFile(const std::string& path, double unit, Wanted wanted, ImportProgress& importProgress)
{
	Result<Mesh> read = readByOurs(path, importProgress, readStl);
	if (!read) return read.error();
	Result<TexturedMesh> textured = inMetres({std::move(read).value(), {}}, path, unit, false, Wanted::Surface);
	if (textured && wanted == Wanted::SurfaceAndPlaces)
		return Error{path +
			": STL files have no texture coordinates; unwrap the mesh (in Blender: Edit Mode, U, Smart UV Project) and "
			"export it with them as OBJ"};
	return textured;
}

Result<TexturedMesh> readPlyFile(const std::string& path, double unit, Wanted wanted, ImportProgress& importProgress)
{
	Result<PlySurface> read = readByOurs(path, importProgress, readPly);
	if (!read) return read.error();
	return inMetres(std::move(read.value().textured), path, unit, read.value().isDouble, wanted);
}

Result<TexturedMesh> readPackageFile(
	const std::string& path, const std::optional<double>& given, Wanted wanted, ImportProgress& importProgress)
{
	Result<PackageSurface> read = readByOurs(path, importProgress, readPackage);
	if (!read) return read.error();
	const Result<Scale> scale = scaleOf(path, unitOf3mf(read.value().unit), given);
	if (!scale) return scale.error();
	Result<TexturedMesh> textured = inMetres(std::move(read.value().textured), path, scale.value().unit, true, wanted);
	if (textured && scale.value().notTaken) textured.value().mesh.notTaken.push_back(*scale.value().notTaken);
	return textured;
}

Result<TexturedMesh> readMesh(const std::string& path, const std::optional<double>& given, Wanted wanted, ImportProgress& importProgress)
{
	if (const auto error = whyNoMeshFile(path)) return *error;
	const std::string ending = meshFileEnding(path);
	Result<TexturedMesh> read = ending == ".stl" ? readStlFile(path, given.value_or(1), wanted, importProgress)
		: ending == ".ply"                       ? readPlyFile(path, given.value_or(1), wanted, importProgress)
		: ending == ".3mf"                       ? readPackageFile(path, given, wanted, importProgress)
												 : importApart(path, given, wanted, importProgress);
	if (read && !importProgress.reach(1)) return importCancelled();
	return read;
}

Result<TexturedMesh> importSurface(const std::string& path, const std::optional<double>& unit, Wanted wanted, const Progress& progress)
{
	if (unit && (!(*unit > 0) || !std::isfinite(*unit))) return Error{"the unit must be a positive number of metres, not " + number(*unit)};
	ImportProgress importProgress(progress);
	if (!importProgress.reach(0)) return importCancelled();
	try
	{
		return readMesh(path, unit, wanted, importProgress);
	}
	catch (const std::exception& exception)
	{
		if (importProgress.cancelled()) return importCancelled();
		return Error{"cannot read " + path + ": " + exception.what() + "; export the mesh again"};
	}
}
}  // namespace

Result<Mesh> importMesh(const std::string& path, std::optional<double> unit, const Progress& progress)
{
	Result<TexturedMesh> read = importSurface(path, unit, Wanted::Surface, progress);
	if (!read) return read.error();
	return std::move(std::move(read).value().mesh);
}

Result<TexturedMesh> importTexturedMesh(const std::string& path, std::optional<double> unit, const Progress& progress)
{
	return importSurface(path, unit, Wanted::SurfaceAndPlaces, progress);
}
}  // namespace ist
