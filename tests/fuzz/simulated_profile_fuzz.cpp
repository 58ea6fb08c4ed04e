// SPDX-License-Identifier: Zlib
// Profiles of simulated devices: an accepted profile is finite.
#include "DeviceBridge/Drivers/Simulated/SimulatedProfile.h"

#include "tests/fuzz/Invariants.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Result<devicebridge::SimulatedProfile> read = devicebridge::parseSimulatedProfile(fuzz::text(data, size));
	if (!fuzz::accepted(read)) return 0;
	const devicebridge::SimulatedProfile& p = read.value();
	fuzz::require(p.mass > 0 && p.inertia > 0 && std::isfinite(p.mass) && std::isfinite(p.inertia), "mass and inertia are positive");
	for (const double number : {p.damping, p.angularDamping, p.handStiffness, p.handAngularStiffness, p.handDamping, p.handAngularDamping})
		fuzz::require(number >= 0 && std::isfinite(number), "dampers and springs are none or positive");
	fuzz::require(p.delayTicks >= 0 && p.delayTicks <= devicebridge::kMaxDelayTicks, "the delay is within what is kept");
	return 0;
}
