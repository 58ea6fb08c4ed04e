// SPDX-License-Identifier: Zlib
#pragma once

namespace ist::tools
{
/// Largest resident memory that this process had, or any process that it started and waited for [bytes]. Windows tells it of this process
/// only.
double peakMemoryBytes();
}  // namespace ist::tools
