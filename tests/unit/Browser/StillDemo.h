// SPDX-License-Identifier: Zlib
#pragma once

#include "demos/browser/base/BrowsableDemo.h"

namespace browser
{
/// A demo of a second in which nothing happens and nothing is shown, for tests that need a part of one.
class StillDemo : public BrowsableDemo
{
public:
	std::optional<ist::Error> prepare(const DemoOptions&) override { return std::nullopt; }
	std::optional<ist::Error> restart() override { return std::nullopt; }
	void step(double) override {}
	double duration() const override { return 1; }
	double time() const override { return 0; }
	void draw(const DrawChoice&, DrawList&) override {}
	Viewpoint viewpoint() const override { return {}; }
	std::vector<Figure> figures() const override { return {}; }
};
}  // namespace browser
