// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Vec3.h"
#include "BulletISTCollision/Core/Query/ContactPatches.h"
#include "BulletISTCollision/Core/Query/Kernels/QueryKernel.h"

#include <algorithm>
#include <limits>
#include <map>
#include <vector>

namespace ist
{
/// Slow grouping of pairs into patches with simple code, pair by pair and in double: the reference for PatchGrouper.
class PatchReference
{
public:
	PatchReference(const kernels::PairStream& pairs, int count, uint32_t ballsA, int maxPatches)
		: m_pairs(pairs),
		  m_patch(size_t(count), -1)
	{
		connect(ballsA);
		while (int(m_patches.size()) < maxPatches && seed())
		{}
		for (size_t i = 0; i < m_patch.size(); ++i)
			if (m_patch[i] < 0) m_patch[i] = nearest(i);
	}
	const std::vector<int>& patch() const { return m_patch; }
	int count() const { return int(m_patches.size()); }
	int components() const { return int(m_components.size()); }

private:
	struct Component
	{
		double rank = 0, left = 0;
		bool hasPatch = false;
	};
	struct Patch
	{
		size_t component = 0;
		Vec3 direction, center;
	};

	double number(int column, size_t i) const { return double(columnOf(m_pairs, column)[i]); }
	Vec3 vector(int column, size_t i) const { return {number(column, i), number(column + 1, i), number(column + 2, i)}; }
	Vec3 force(size_t i) const { return vector(kernels::PairStream::Force, i); }
	Vec3 centroid(size_t i) const { return vector(kernels::PairStream::Centroid, i); }
	double size(size_t i) const { return number(kernels::PairStream::Size, i); }
	double rank(size_t i) const { return number(kernels::PairStream::Rank, i); }

	/// Copies the smaller of two labels to every pair that shares a ball, until nothing changes.
	void connect(uint32_t ballsA)
	{
		std::map<uint32_t, size_t> label;  // for each ball, the first pair of its component
		bool changed = true;
		m_component.resize(m_patch.size());
		for (size_t i = 0; i < m_patch.size(); ++i) m_component[i] = i;
		while (changed)
		{
			changed = false;
			for (size_t i = 0; i < m_patch.size(); ++i)
				for (const uint32_t ball : {m_pairs.a[i], m_pairs.b[i] + ballsA})
				{
					size_t& of = label.try_emplace(ball, m_component[i]).first->second;
					const size_t least = std::min(of, m_component[i]);
					changed = changed || of != least || m_component[i] != least;
					of = m_component[i] = least;
				}
		}
		std::map<size_t, size_t> numbers;
		for (size_t& component : m_component) component = numbers.try_emplace(component, numbers.size()).first->second;
		m_components.resize(numbers.size());
		for (size_t i = 0; i < m_patch.size(); ++i) m_components[m_component[i]].rank += rank(i);
		for (Component& component : m_components) component.left = component.rank;
	}

	bool seed()
	{
		Component* best = nullptr;
		for (Component& component : m_components)
			if (!(component.hasPatch && component.left <= 0.05 * component.rank) && (!best || component.left > best->left))
				best = &component;
		if (!best) return false;
		const size_t own = size_t(best - m_components.data());
		std::vector<size_t> open;
		for (size_t i = 0; i < m_patch.size(); ++i)
			if (m_patch[i] < 0 && m_component[i] == own) open.push_back(i);
		const auto strongest = std::max_element(open.begin(), open.end(), [&](size_t i, size_t j) { return size(i) < size(j); });
		const bool hasDirection = strongest != open.end() && size(*strongest) > 0;
		if (!hasDirection && best->hasPatch) return best->left = 0, true;
		Patch patch;
		patch.component = own;
		Vec3 sum, moment;
		double ranks = 0;
		for (const size_t i : open)
		{
			const double cosine = hasDirection && size(i) > 0 ? dot(force(i), force(*strongest)) / size(i) / size(*strongest) : 0;
			if (hasDirection && !(size(i) > 0 && cosine >= 0.70710678)) continue;
			m_patch[i] = int(m_patches.size());
			sum += force(i);
			moment += centroid(i) * rank(i);
			ranks += rank(i);
		}
		patch.direction = normalized(sum);
		patch.center = moment / ranks;
		best->left = std::max(0.0, best->left - ranks);
		best->hasPatch = true;
		m_patches.push_back(patch);
		return true;
	}

	int nearest(size_t i) const
	{
		double extent = 0;
		for (const Patch& patch : m_patches) extent = std::max(extent, distance(patch.center, m_patches[0].center));
		int best = 0;
		double most = -std::numeric_limits<double>::infinity();
		for (size_t p = 0; p < m_patches.size(); ++p)
		{
			if (m_components[m_component[i]].hasPatch && m_patches[p].component != m_component[i]) continue;
			double score = extent > 0 ? -distance(m_patches[p].center, centroid(i)) / extent : 0;
			if (size(i) > 0) score += dot(m_patches[p].direction, force(i)) / size(i);
			if (score <= most) continue;
			most = score;
			best = int(p);
		}
		return best;
	}

	const kernels::PairStream& m_pairs;
	std::vector<int> m_patch;
	std::vector<size_t> m_component;
	std::vector<Component> m_components;
	std::vector<Patch> m_patches;
};
}  // namespace ist
