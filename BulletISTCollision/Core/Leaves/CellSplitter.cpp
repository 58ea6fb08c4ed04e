// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Leaves/CellSplitter.h"

#include <algorithm>
#include <array>
#include <optional>
#include <queue>
#include <utility>

namespace ist
{
namespace
{
// Source: bench_truth. With half of this weight cells are cut into curved slabs that no ellipsoid fits.
constexpr double kPositionWeight = 1;
constexpr int kMostMoves = 8;  // limit for the moves of the plane between the halves
constexpr size_t kEnoughToMove = 1000;

constexpr size_t kMinimumToSplit = 24;
constexpr size_t kMinimumOfChild = 8;
// Pieces are split in parallel. A half seldom comes before a piece with this share of its parent's priority.
constexpr double kBatchSpan = 0.5;
constexpr size_t kLargestBatch = 16384;
[[maybe_unused]] constexpr size_t fewestToShare = 2000;  // samples

using Vec6 = std::array<double, 6>;
using Mat6 = std::array<Vec6, 6>;

double priority(const CellPiece& piece) { return splitPriority(piece.mass, piece.meanRadius(), piece.normal); }

Vec6 feature(const CellSample& s, const CellPiece& piece)
{
	const Vec3 x = (s.position() - piece.centroid) * (kPositionWeight / piece.meanRadius());
	const Vec3 n = s.normal() - piece.normal;
	return {x.x, x.y, x.z, n.x, n.y, n.z};
}

double dot(const Vec6& a, const Vec6& b)
{
	double sum = 0;
	for (int i = 0; i < 6; ++i) sum += a[i] * b[i];
	return sum;
}

/// Principal axis of a positive semidefinite matrix. Repeated squaring leaves the projector onto it.
Vec6 principalAxis(Mat6 c)
{
	for (int step = 0; step < 10; ++step)
	{
		double trace = 0;
		for (int i = 0; i < 6; ++i) trace += c[i][i];
		if (!(trace > 0)) return {1, 0, 0, 0, 0, 0};
		Mat6 square;
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) square[i][j] = dot(c[i], c[j]) / (trace * trace);
		c = square;
	}
	const auto longest = std::max_element(c.begin(), c.end(), [](const Vec6& a, const Vec6& b) { return dot(a, a) < dot(b, b); });
	return *longest;
}

struct Cut
{
	Vec6 axis{};
	double threshold = 0;
	bool below(const Vec6& f) const { return dot(axis, f) < threshold; }
};

/// The first cut goes through the mean, across the principal axis.
Cut firstCut(const CellSample* samples, const CellPiece& piece)
{
	Vec6 mean{};
	Mat6 second{};
	double weight = 0;
	for (size_t k = piece.begin; k < piece.end; ++k)
	{
		const double w = samples[k].weight;
		const Vec6 f = feature(samples[k], piece);
		weight += w;
		for (int i = 0; i < 6; ++i)
		{
			mean[i] += w * f[i];
			for (int j = 0; j <= i; ++j) second[i][j] += w * f[i] * f[j];
		}
	}
	for (double& m : mean) m /= weight;
	for (int i = 0; i < 6; ++i)
		for (int j = 0; j <= i; ++j) second[i][j] = second[j][i] = second[i][j] / weight - mean[i] * mean[j];
	const Vec6 axis = principalAxis(second);
	return {axis, dot(axis, mean)};
}

/// One step of Lloyd's algorithm: moves to the plane halfway between the means of the halves, or of some hundred samples of each.
bool move(Cut& cut, const CellSample* samples, const CellPiece& piece)
{
	Vec6 sum[2] = {};
	double weight[2] = {};
	const size_t stride = std::max<size_t>(1, (piece.end - piece.begin) / kEnoughToMove);
	for (size_t k = piece.begin; k < piece.end; k += stride)
	{
		const double w = samples[k].weight;
		const Vec6 f = feature(samples[k], piece);
		const int half = cut.below(f) ? 0 : 1;
		weight[half] += w;
		for (int i = 0; i < 6; ++i) sum[half][i] += w * f[i];
	}
	if (!(weight[0] > 0 && weight[1] > 0)) return false;
	const Cut before = cut;
	cut.threshold = 0;
	for (int i = 0; i < 6; ++i)
	{
		const double a = sum[0][i] / weight[0], b = sum[1][i] / weight[1];
		cut.axis[i] = b - a;
		cut.threshold += 0.5 * (b * b - a * a);
	}
	return cut.axis != before.axis;
}

CellPiece pieceOfSamples(const CellSample* samples, size_t begin, size_t end, uint32_t sphere)
{
	CellPiece piece;
	piece.begin = begin;
	piece.end = end;
	piece.sphere = sphere;
	for (size_t k = begin; k < end; ++k)
	{
		const CellSample& s = samples[k];
		const double w = s.weight;
		piece.mass += w;
		piece.centroid += s.position() * w;
		piece.normal += s.normal() * w;
		piece.depth += s.depth * w;
	}
	piece.centroid *= 1 / piece.mass;
	piece.normal *= 1 / piece.mass;
	piece.depth /= piece.mass;
	for (size_t k = begin; k < end; ++k)
		piece.shape += SymmetricMatrix3::square(samples[k].position() - piece.centroid) * (5 * samples[k].weight / piece.mass);
	return piece;
}

std::optional<std::pair<CellPiece, CellPiece>> split(CellSample* samples, const CellPiece& parent)
{
	if (parent.end - parent.begin < kMinimumToSplit || !(parent.meanRadius() > 0)) return {};
	Cut cut = firstCut(samples, parent);
	for (int step = 0; step < kMostMoves && move(cut, samples, parent); ++step)
	{}
	CellSample *begin = samples + parent.begin, *end = samples + parent.end;
	CellSample* middle = std::partition(begin, end, [&](const CellSample& s) { return cut.below(feature(s, parent)); });
	if (size_t(middle - begin) < kMinimumOfChild || size_t(end - middle) < kMinimumOfChild) return {};

	const size_t at = size_t(middle - samples);
	CellPiece a = pieceOfSamples(samples, parent.begin, at, parent.sphere);
	CellPiece b = pieceOfSamples(samples, at, parent.end, parent.sphere);
	if (!(a.meanRadius() > 0) || !(b.meanRadius() > 0)) return {};
	const double scale = parent.mass / (a.mass + b.mass);
	a.mass *= scale;
	b.mass *= scale;
	return std::pair{a, b};
}
}  // namespace

MomentEllipsoid momentEllipsoid(const CellPiece& piece)
{
	MomentEllipsoid e = momentEllipsoid(piece.centroid, piece.shape, piece.mass);
	e.setNormal(piece.normal);
	e.depth = float(piece.depth);
	e.sphere = piece.sphere;
	return e;
}

std::vector<CellPiece> splitCells(CellSample* samples, const std::vector<CellPiece>& cells, size_t leafCount, [[maybe_unused]] int threads)
{
	std::vector<CellPiece> pieces = cells;
	using Waiting = std::pair<double, size_t>;  // priority, piece
	const auto before = [](const Waiting& a, const Waiting& b) { return a.first != b.first ? a.first < b.first : a.second > b.second; };
	std::priority_queue<Waiting, std::vector<Waiting>, decltype(before)> queue(before);
	for (size_t i = 0; i < pieces.size(); ++i) queue.push({priority(pieces[i]), i});

	std::vector<Waiting> batch;
	std::vector<std::optional<std::pair<CellPiece, CellPiece>>> halves;
	while (pieces.size() < leafCount && !queue.empty())
	{
		const double least = kBatchSpan * queue.top().first;
		const size_t most = std::min(kLargestBatch, leafCount - pieces.size());
		for (batch.clear(); !queue.empty() && batch.size() < most && queue.top().first >= least; queue.pop()) batch.push_back(queue.top());
		halves.assign(batch.size(), {});
		[[maybe_unused]] size_t reordered = 0;  // used only with OpenMP
		for (const Waiting& waiting : batch) reordered += pieces[waiting.second].end - pieces[waiting.second].begin;
			// At first few pieces hold most of the samples, so the number of samples decides whether threads share the work.
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (reordered >= fewestToShare)
		for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(batch.size()); ++i)
			halves[size_t(i)] = split(samples, pieces[batch[size_t(i)].second]);
		size_t done = 0;
		for (; done < batch.size() && (queue.empty() || !before(batch[done], queue.top())); ++done)
		{
			if (!halves[done]) continue;
			const auto& [first, second] = *halves[done];
			const size_t index = batch[done].second;
			pieces[index] = first;
			pieces.push_back(second);
			queue.push({priority(first), index});
			queue.push({priority(second), pieces.size() - 1});
		}
		for (; done < batch.size(); ++done) queue.push(batch[done]);
	}
	std::sort(pieces.begin(), pieces.end(),
		[](const CellPiece& a, const CellPiece& b) { return a.sphere != b.sphere ? a.sphere < b.sphere : a.begin < b.begin; });
	return pieces;
}
}  // namespace ist
