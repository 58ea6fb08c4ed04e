// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Progress.h"
#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Import/Formats/ImportCancelled.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <optional>
#include <string>

namespace ist
{
// Parts of the import that all formats share.

/// Contents to take from a file.
enum class Wanted
{
	Surface,
	SurfaceAndPlaces  // with texture coordinates
};

/// Reports progress of the stage "import". It never goes back.
class ImportProgress
{
public:
	explicit ImportProgress(const Progress& progress) : m_progress(progress) {}
	/// False if the import shall stop.
	bool reach(double fraction);
	bool cancelled() const { return m_cancelled; }

private:
	const Progress& m_progress;
	double m_fraction = 0;
	bool m_cancelled = false;
};

/// Refuses a file for what reading it takes.
Error takesTooMuchMemory(const std::string& path);

/// Share of the stage that reading takes. Copying the triangles takes the rest.
constexpr double kReading = 0.9;
/// Largest distance between neighbouring single-precision coordinates, as a share of the longest side.
constexpr double kBlurred = 1e-3;
/// What to do with a mesh that has no texture coordinates.
constexpr const char* kUnwrap = "unwrap the mesh (in Blender: Edit Mode, U, Smart UV Project) and export it with them";

/// Distance between neighbouring single-precision values at the farthest coordinate of a box, as a share of its longest side.
double blur(const Box& box);
/// Refuses meshes that nothing can be made of. `worstBlur`: the largest blur of its parts.
std::optional<Error> whyUnusable(const Mesh& mesh, const std::string& path, double worstBlur);
/// Refuses texture coordinates that are not finite.
std::optional<Error> notFinitePlace(const TexturedMesh& textured, const std::string& path);
}  // namespace ist
