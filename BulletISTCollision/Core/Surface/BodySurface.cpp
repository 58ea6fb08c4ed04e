// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Surface/BodySurface.h"

#include "BulletISTCollision/Core/Base/CounterRandom.h"

#include <cmath>
#include <utility>

namespace ist
{
namespace
{
constexpr int kErrorPoints = 4096;
constexpr uint64_t kErrorStream = 128;
/// A surface that is not exact enough is built with so many times the pieces, at most this often, and only if the error falls to this
/// share: that of a rough mesh does not.
constexpr int64_t kFinerPieces = 4;
constexpr int kMostRefinements = 2;
constexpr double kFinerError = 0.6;

Result<BodySurface> bodySurface(const MeshDistance& mesh, Result<ContactSurface> surface, const BodySurfaceOptions& options)
{
	if (!surface) return surface.error();
	Result<DepthField> field = buildDepthField(mesh, {options.cells, options.seed, options.threads, options.progress});
	if (!field) return field.error();
	return BodySurface{std::move(surface).value(), std::move(field).value()};
}
}  // namespace

size_t BodySurface::bytes() const
{
	const auto of = [](const auto& array) { return array.size() * sizeof(array[0]); };
	return of(surface.nodes) + of(surface.elements) + of(field.nodes) + of(field.cells);
}

std::string BodySurface::validate() const
{
	if (std::string fault = surface.validate(); !fault.empty()) return "surface: " + fault;
	if (std::string fault = field.validate(); !fault.empty()) return "depth field: " + fault;
	return tables.empty() ? "the query tables are missing" : "";
}

Result<BodySurface> buildBodySurface(const MeshDistance& mesh, const BodySurfaceOptions& options)
{
	return buildBodySurface(mesh, buildContactSurface(mesh.mesh(), {options.elements, options.progress}), options);
}

double depthErrorOnSurface(const DepthField& field, const Mesh& mesh, uint64_t seed)
{
	CounterRandom random(seed, kErrorStream, 0);
	const double step = surfaceArea(mesh) / kErrorPoints;
	double squares = 0, passed = 0, next = step * random.next();
	int64_t count = 0;
	for (const auto& t : mesh.triangles)
	{
		const Vec3 &a = mesh.vertices[t[0]], u = mesh.vertices[t[1]] - a, v = mesh.vertices[t[2]] - a;
		for (passed += 0.5 * norm(cross(u, v)); next < passed; next += step)
		{
			const double s = std::sqrt(random.next()), share = random.next();
			const DepthField::Value at = field.at(a + s * (1 - share) * u + s * share * v);
			if (at.cell == DepthNode::kOutside) continue;
			squares += at.depth * at.depth;
			++count;
		}
	}
	return count > 0 ? std::sqrt(squares / double(count)) : 0;
}

Result<BodySurface> buildBodySurface(const MeshDistance& mesh, Result<ContactSurface> surface, const BodySurfaceOptions& options)
{
	Result<BodySurface> body = bodySurface(mesh, std::move(surface), options);
	if (!body) return body;
	BodySurfaceOptions finer = options;
	// What was reported stays so.
	if (options.progress) finer.progress = [&](const char*, double) { return options.progress("field", 1); };
	const auto errorOf = [&](const BodySurface& surface) { return depthErrorOnSurface(surface.field, mesh.mesh(), options.seed); };
	double error = options.error > 0 ? errorOf(body.value()) : 0;
	for (int round = 0; error > options.error && round < kMostRefinements; ++round)
	{
		finer.cells *= kFinerPieces;
		finer.elements *= kFinerPieces;
		Result<BodySurface> better = bodySurface(mesh, buildContactSurface(mesh.mesh(), {finer.elements, finer.progress}), finer);
		if (!better) return better;
		const double betterError = errorOf(better.value());
		if (betterError > kFinerError * error) break;
		body = std::move(better);
		error = betterError;
	}
	body.value().tables = buildQueryTables(body.value().surface, body.value().field);
	return body;
}
}  // namespace ist
