// SPDX-License-Identifier: Zlib
#include "tests/bench/motion/MotionPage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace bench
{
using Contact = MotionSettings::Contact;

std::string shownError(double error)
{
	if (error < 0) return "-";
	return std::isfinite(error) ? scenes::formatNumber(error, 2) : "lost";
}

void print(const MotionFindings& found)
{
	std::printf("%s: reference %d Hz\n", found.entry.name, found.referenceRate);
	for (const Contact contact : {Contact::Given, Contact::Default})
	{
		const MotionTruth& t = found.truths[int(contact)];
		std::printf("  %s: reference within %s, closed form %s; a perturbation grows %s-fold; judged until %.2f s\n",
			contact == Contact::Given ? "given" : "default", shownError(t.convergence).c_str(), shownError(t.closedError).c_str(),
			shownError(t.growth.factor).c_str(), t.until);
	}
	for (const MotionRow& r : found.rows)
		std::printf("  %-22s error %9s single %9s closed %9s  %8.0f queries %9.0f pairs %8.1f ms a second\n", r.settings.name().c_str(),
			shownError(r.error).c_str(), shownError(r.singleError).c_str(), shownError(r.closedError).c_str(), r.cost.queries, r.cost.pairs,
			1e3 * r.cost.seconds);
	std::fflush(stdout);
}

MedianGain medianGain(const std::vector<MotionFindings>& all, size_t tolerance, double MotionGain::*gain)
{
	std::vector<double> values;
	for (const MotionFindings& f : all)
		if (f.entry.hasEvents && f.gains[tolerance].*gain > 0) values.push_back(f.gains[tolerance].*gain);
	if (values.empty()) return {};
	std::sort(values.begin(), values.end());
	return {0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]), values.size()};
}

void printGains(const std::vector<MotionFindings>& all)
{
	std::printf(
		"\ncost of the best fixed step over steps chosen in hindsight: by queries and steps, by time, with velocities charged; over a "
		"control of the step: by queries and steps, with velocities charged\n");
	for (const MotionFindings& f : all)
	{
		std::printf("  %-14s", f.entry.name);
		for (const MotionGain& g : f.gains)
			std::printf("  %7.0e: %5d Hz %4.2f %4.2f %4.2f; %4.2f %4.2f", g.tolerance, g.rate, g.byCount, g.bySeconds, g.byVelocity,
				g.byControl, g.byControlOfVelocity);
		std::printf("\n");
	}
	std::printf("  %-14s", "median, events");
	for (size_t i = 0; i < kTolerances.size(); ++i)
	{
		const auto median = [&](double MotionGain::*gain) { return medianGain(all, i, gain).median; };
		std::printf("  %7.0e: %2zu scenes %4.2f %4.2f %4.2f; %4.2f %4.2f", kTolerances[i], medianGain(all, i, &MotionGain::byCount).scenes,
			median(&MotionGain::byCount), median(&MotionGain::bySeconds), median(&MotionGain::byVelocity), median(&MotionGain::byControl),
			median(&MotionGain::byControlOfVelocity));
	}
	std::printf("\n");
}
}  // namespace bench
