// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/DrawList.h"

using namespace ist;

namespace browser
{
namespace
{
constexpr double kSharp = 0.766;  // cosine of 40 degrees

void store(float* to, const Vec3& v)
{
	for (int i = 0; i < 3; ++i) to[i] = float(v[i]);
}
}  // namespace

std::shared_ptr<const SurfaceModel> makeSurfaceModel(const Mesh& mesh)
{
	auto model = std::make_shared<SurfaceModel>();
	model->box = bounds(mesh);
	std::vector<Vec3> area(mesh.triangles.size());
	std::vector<std::vector<uint32_t>> around(mesh.vertices.size());
	for (size_t t = 0; t < mesh.triangles.size(); ++t)
	{
		const auto& [a, b, c] = mesh.triangles[t];
		area[t] = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
		for (const uint32_t v : mesh.triangles[t]) around[v].push_back(uint32_t(t));
	}
	for (size_t t = 0; t < mesh.triangles.size(); ++t)
		for (const uint32_t v : mesh.triangles[t])
		{
			const Vec3 own = normalized(area[t]);
			Vec3 sum;
			for (const uint32_t other : around[v])
				if (dot(own, normalized(area[other])) > kSharp) sum += area[other];
			SurfaceModel::Corner corner;
			store(corner.position, mesh.vertices[v]);
			store(corner.normal, squaredNorm(sum) > 0 ? normalized(sum) : own);
			model->corners.push_back(corner);
		}
	return model;
}

std::shared_ptr<const SurfaceModel> colouredModel(const SurfaceModel& model, const Mesh& mesh, const std::vector<Colour>& ofVertices)
{
	auto coloured = std::make_shared<SurfaceModel>(model);
	coloured->colours.clear();
	for (const auto& t : mesh.triangles)
		for (const uint32_t v : t) coloured->colours.push_back(ofVertices[v]);
	return coloured;
}

void DrawList::addKey(const Colour& colour, const std::string& text)
{
	for (const DrawnKey& key : keys)
		if (key.text == text) return;
	keys.push_back({colour, text});
}

void DrawList::clear()
{
	surfaces.clear();
	spheres.clear();
	discs.clear();
	arrows.clear();
	lines.clear();
	texts.clear();
	keys.clear();
	const DrawList blank;
	ground = blank.ground;
	groundHeight = blank.groundHeight;
	groundNormal = blank.groundNormal;
	gridCell = blank.gridCell;
	water = blank.water;
	wireframe = blank.wireframe;
	shadows = blank.shadows;
}
}  // namespace browser
