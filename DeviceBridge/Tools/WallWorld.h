// SPDX-License-Identifier: Zlib
#pragma once

#include <algorithm>

#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge::tools
{
/// A world with one elastic wall that fills z < 0; the tool is the handle itself.
class WallWorld final : public ContactSource
{
public:
	explicit WallWorld(double stiffness) : m_stiffness(stiffness) {}

	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, -hand.X_WH.translation.z);
		const ist::Wrench onTool{{0, 0, m_stiffness * depth}, {}};
		step.coupling = -1.0 * onTool;
		if (depth == 0) return;
		step.contacts[0] = {onTool, hand.X_WH.translation, {0, 0, 1}, 0, 0, this};
		step.contactCount = 1;
	}

private:
	double m_stiffness;  ///< stiffness of the wall [N/m]
};
}  // namespace devicebridge::tools
