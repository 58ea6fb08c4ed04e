// SPDX-License-Identifier: Zlib
#include "demos/browser/render/Picture.h"

#include <algorithm>

namespace browser
{
namespace
{
constexpr int kWindow = 8;

/// Luma of the picture at half its size.
std::vector<double> halved(const Picture& p)
{
	const int w = p.width / 2, h = p.height / 2;
	std::vector<double> out(size_t(w) * size_t(h));
	for (int y = 0; y < h; ++y)
		for (int x = 0; x < w; ++x)
			for (int k = 0; k < 4; ++k)
			{
				const uint8_t* rgb = &p.pixels[3 * (size_t(2 * y + k / 2) * size_t(p.width) + size_t(2 * x + k % 2))];
				out[size_t(y) * size_t(w) + size_t(x)] += (0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]) / 4;
			}
	return out;
}

struct Similarity
{
	double mean = 0, worst = 1;
};

Similarity compare(const Picture& a, const Picture& b)
{
	if (a.width != b.width || a.height != b.height || a.width < 2 * kWindow || a.height < 2 * kWindow) return {0, 0};
	const std::vector<double> p = halved(a), q = halved(b);
	const int w = a.width / 2, h = a.height / 2;
	const double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255, n = kWindow * kWindow;
	Similarity out;
	int windows = 0;
	for (int y = 0; y + kWindow <= h; y += kWindow / 2)
		for (int x = 0; x + kWindow <= w; x += kWindow / 2)
		{
			double sp = 0, sq = 0, pp = 0, qq = 0, pq = 0;
			for (int j = 0; j < kWindow; ++j)
				for (int i = 0; i < kWindow; ++i)
				{
					const size_t at = size_t(y + j) * size_t(w) + size_t(x + i);
					sp += p[at], sq += q[at], pp += p[at] * p[at], qq += q[at] * q[at], pq += p[at] * q[at];
				}
			const double mp = sp / n, mq = sq / n, vp = pp / n - mp * mp, vq = qq / n - mq * mq, cov = pq / n - mp * mq;
			const double s = (2 * mp * mq + c1) * (2 * cov + c2) / ((mp * mp + mq * mq + c1) * (vp + vq + c2));
			out.mean += s;
			out.worst = std::min(out.worst, s);
			++windows;
		}
	out.mean /= windows;
	return out;
}
}  // namespace

Picture withFewerColours(const Picture& picture)
{
	Picture out = picture;
	for (uint8_t& value : out.pixels) value = uint8_t(std::min(255, ((value + 2) / 4) * 4));
	return out;
}

double similarity(const Picture& a, const Picture& b) { return compare(a, b).mean; }
double worstSimilarity(const Picture& a, const Picture& b) { return compare(a, b).worst; }
}  // namespace browser
