// SPDX-License-Identifier: Zlib
#include "demos/browser/drawing/PackedSpheres.h"

#include "BulletISTCollision/Core/Tree/TreeLevels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

using namespace ist;

namespace browser
{
void PackedSpheres::draw(const DrawChoice& choice, const Pose& X_WM, DrawList& list, size_t count) const
{
	if (!m_tree || !(choice.spheres || choice.sphereLevels)) return;
	std::shared_ptr<const SpheresModel>& model = choice.sphereLevels ? m_byLevel : m_bySize;
	if (!model) model = choice.sphereLevels ? spheresByLevel(*m_tree) : spheresBySize(*m_tree);
	list.spheres.push_back({model, X_WM, std::min(count, model->spheres.size()), 1});
}

std::shared_ptr<const SpheresModel> spheresBySize(const InnerSphereTree& tree)
{
	auto model = std::make_shared<SpheresModel>();
	if (tree.spheres.empty()) return model;
	const double largest = tree.spheres.front().r;
	double smallest = largest;
	for (const Sphere& s : tree.spheres) smallest = std::min(smallest, double(s.r));
	const double range = std::max(std::log(largest / smallest), 1e-6);
	for (const Sphere& s : tree.spheres)
	{
		const Vec3 c = tree.origin + s.center();
		model->spheres.push_back({float(c.x), float(c.y), float(c.z), s.r, float(std::log(largest / s.r) / range)});
	}
	return model;
}

std::shared_ptr<const SpheresModel> spheresByLevel(const InnerSphereTree& tree)
{
	auto model = std::make_shared<SpheresModel>(*spheresBySize(tree));
	const std::vector<int> levels = levelsOfSpheres(tree.law, model->spheres.size());
	model->levels.assign(levels.begin(), levels.end());
	for (size_t i = 0; i < levels.size(); ++i) model->spheres[i].shade = float(levelShade(levels[i]));
	return model;
}

void addSphereKeys(const std::set<int>& answering, DrawList& list)
{
	std::array<size_t, 256> counts{};
	bool bySize = false;
	for (const DrawnSpheres& s : list.spheres)
	{
		bySize = bySize || s.model->levels.empty();
		for (size_t i = 0; i < std::min(s.count, s.model->levels.size()); ++i) ++counts[s.model->levels[i]];
	}
	if (bySize)
	{
		list.addKey(shadeColour(0), "a body's largest spheres");
		list.addKey(shadeColour(0.5), "the middle of their sizes");
		list.addKey(shadeColour(1), "its smallest");
	}
	for (int level = int(counts.size()) - 1; level >= 0; --level)
	{
		if (counts[size_t(level)] == 0) continue;
		const std::string lead = level > 0 ? "lead at level " + std::to_string(level) : "lead among the leaves alone";
		list.addKey(shadeColour(levelShade(level)),
			lead + ": " + std::to_string(counts[size_t(level)]) + " spheres" + (answering.count(level) ? "; this level answers" : ""));
	}
}
}  // namespace browser
