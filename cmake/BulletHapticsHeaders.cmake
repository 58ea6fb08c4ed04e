# SPDX-License-Identifier: Zlib
# The headers that are installed: what README, the pages and the consumers in tests/consumer include, and what those headers include.
# Every other header is private and lies beside the source that uses it.
set(BULLETHAPTICS_HEADERS
	BulletHapticForce/Law/btContactFriction.h
	BulletHapticForce/Law/btContactLaw.h
	BulletHapticForce/Law/btContactMaterial.h
	BulletHapticForce/Law/btEnergyLaw.h
	BulletHapticForce/Law/btExplicitPairs.h
	BulletHapticForce/Law/btPaperLaw.h
	BulletHapticForce/Solver/btContactEnergyTank.h
	BulletHapticForce/Solver/btEnvelopeFactor.h
	BulletHapticForce/Solver/btIslandBlockSolver.h
	BulletHapticForce/Solver/btIslandJoints.h
	BulletHapticForce/Solver/btKeyedLists.h
	BulletHapticForce/Solver/btSweepAcceleration.h
	BulletHapticForce/Solver/btCompensatedPoses.h
	BulletHapticForce/Solver/btVolumetricIslands.h
	BulletHapticForce/Solver/btVolumetricLinks.h
	BulletHapticForce/Solver/btVolumetricRows.h
	BulletHapticForce/Solver/btVolumetricSolver.h
	BulletHapticForce/Solver/btVolumetricStatistics.h
	BulletHapticForce/World/btEnergyAudit.h
	BulletHapticForce/World/btISTSceneReport.h
	BulletHapticForce/World/btISTDebugDraw.h
	BulletHapticForce/World/btISTSubsteps.h
	BulletHapticForce/World/btISTWarnings.h
	BulletHapticForce/World/btISTWorld.h
	BulletHapticForce/World/btVolumetricInstallation.h
	BulletHapticForce/btBulletHapticForceCommon.h
	BulletISTCollision/Contact/btISTContactStore.h
	BulletISTCollision/Contact/btISTContactCache.h
	BulletISTCollision/Core/Accuracy/ForceErrorBound.h
	BulletISTCollision/Core/Accuracy/LevelCalibration.h
	BulletISTCollision/Core/Accuracy/AdaptiveLevel.h
	BulletISTCollision/Core/Asset/AssetFile.h
	BulletISTCollision/Core/Base/DemandZeroArray.h
	BulletISTCollision/Core/Base/FrozenArray.h
	BulletISTCollision/Core/Base/InstructionSet.h
	BulletISTCollision/Core/Base/Pose.h
	BulletISTCollision/Core/Base/Progress.h
	BulletISTCollision/Core/Base/Result.h
	BulletISTCollision/Core/Base/SymmetricMatrix3.h
	BulletISTCollision/Core/Base/Vec3.h
	BulletISTCollision/Core/Build/TreeBuilder.h
	BulletISTCollision/Core/Build/TreeCache.h
	BulletISTCollision/Core/Build/TreeWorker.h
	BulletISTCollision/Core/Distance/MeshDistance.h
	BulletISTCollision/Core/Force/ContactPoints.h
	BulletISTCollision/Core/Force/PairLaws.h
	BulletISTCollision/Core/Force/PressureField.h
	BulletISTCollision/Core/Force/TaxelArray.h
	BulletISTCollision/Core/Geometry/AnalyticField.h
	BulletISTCollision/Core/Geometry/MomentEllipsoid.h
	BulletISTCollision/Core/Geometry/SpherePacking.h
	BulletISTCollision/Core/Import/MeshFileVertices.h
	BulletISTCollision/Core/Import/MeshImport.h
	BulletISTCollision/Core/Mesh/LengthUnit.h
	BulletISTCollision/Core/Mesh/Mesh.h
	BulletISTCollision/Core/Mesh/MatchingVertices.h
	BulletISTCollision/Core/Mesh/MeshAxes.h
	BulletISTCollision/Core/Mesh/MeshDivision.h
	BulletISTCollision/Core/Mesh/MeshShapes.h
	BulletISTCollision/Core/Mesh/TexturedMesh.h
	BulletISTCollision/Core/Faces/ContactFaces.h
	BulletISTCollision/Core/Query/OverlapQuery.h
	BulletISTCollision/Core/Query/VerletList.h
	BulletISTCollision/Core/Query/ProximityQuery.h
	BulletISTCollision/Core/Repair/MeshGround.h
	BulletISTCollision/Core/Repair/MeshRepair.h
	BulletISTCollision/Core/Surface/BodySurface.h
	BulletISTCollision/Core/Surface/ContactSurface.h
	BulletISTCollision/Core/Surface/DepthField.h
	BulletISTCollision/Core/Surface/QueryTables.h
	BulletISTCollision/Core/Tree/BallTree.h
	BulletISTCollision/Core/Tree/InnerSphereTree.h
	BulletISTCollision/Core/Tuning/StableTimeStep.h
	BulletISTCollision/Dispatch/btISTCollisionAlgorithm.h
	BulletISTCollision/Dispatch/btISTRegistration.h
	BulletISTCollision/Registry/btISTRegistry.h
	BulletISTCollision/Registry/btISTShapeMesh.h
	BulletISTCollision/Registry/btISTTreeSource.h
	BulletISTCollision/Registry/btISTPairFilter.h
	BulletISTCollision/Registry/btPrecisionGuard.h
	BulletISTCollision/btBulletISTCollisionCommon.h
	DeviceBridge/Bullet/BulletContactSource.h
	DeviceBridge/Bullet/BulletDecoupledSource.h
	DeviceBridge/Bullet/BulletHand.h
	DeviceBridge/Bullet/BulletHandSource.h
	DeviceBridge/Bullet/BulletHeatMap.h
	DeviceBridge/Bullet/BulletLocalWorld.h
	DeviceBridge/Bullet/BulletToolContacts.h
	DeviceBridge/Bullet/BulletWorldCoupling.h
	DeviceBridge/Bullet/ToolStiffness.h
	DeviceBridge/Coupling/AdaptiveCoupling.h
	DeviceBridge/Coupling/CouplingSwitch.h
	DeviceBridge/Coupling/DeviceGains.h
	DeviceBridge/Coupling/VirtualCoupling.h
	DeviceBridge/Decorators/DeviceDecorator.h
	DeviceBridge/Decorators/MountedDevice.h
	DeviceBridge/Device/Device.h
	DeviceBridge/Device/DeviceAddress.h
	DeviceBridge/Device/DeviceLink.h
	DeviceBridge/Device/HandState.h
	DeviceBridge/Device/Recording.h
	DeviceBridge/Device/ThreadedDevice.h
	DeviceBridge/Drivers/AssumedLimits.h
	DeviceBridge/Drivers/DeviceRegistry.h
	DeviceBridge/Drivers/Glove/GloveAngles.h
	DeviceBridge/Drivers/Glove/GloveHand.h
	DeviceBridge/Drivers/Simulated/SimulatedDevice.h
	DeviceBridge/Drivers/Simulated/SimulatedProfile.h
	DeviceBridge/Hand/BvhHand.h
	DeviceBridge/Hand/ContactPoseHands.h
	DeviceBridge/Hand/Grasp/GraspQuality.h
	DeviceBridge/Hand/Grasp/HeatMap.h
	DeviceBridge/Hand/Grasp/HeatMapFile.h
	DeviceBridge/Hand/Grasp/HeatMapTexture.h
	DeviceBridge/Hand/Grasp/Picture.h
	DeviceBridge/Hand/HandFromPoints.h
	DeviceBridge/Hand/HandModel.h
	DeviceBridge/Hand/HandMotion.h
	DeviceBridge/Hand/HandParts.h
	DeviceBridge/Hand/HandPosture.h
	DeviceBridge/Hand/HandRecording.h
	DeviceBridge/Hand/HandSampleFault.h
	DeviceBridge/Hand/HandShape.h
	DeviceBridge/Hand/HandTrackingMonitor.h
	DeviceBridge/Loop/AnsweringThread.h
	DeviceBridge/Loop/ContactSource.h
	DeviceBridge/Loop/ForceLaw.h
	DeviceBridge/Loop/GapBridge.h
	DeviceBridge/Loop/LinearContact.h
	DeviceBridge/Loop/ModelAge.h
	DeviceBridge/Loop/SteppingThread.h
	DeviceBridge/Loop/ThreadedForceLaw.h
	DeviceBridge/Loop/WorldMirror.h
	DeviceBridge/Plugins/devicebridge_plugin.h
	DeviceBridge/Safety/AgeFade.h
	DeviceBridge/Safety/FaultCause.h
	DeviceBridge/Safety/GainRamp.h
	DeviceBridge/Safety/HeatBudget.h
	DeviceBridge/Safety/PassivityController.h
	DeviceBridge/Safety/SafetyLimiter.h
	DeviceBridge/Safety/Saturation.h
	DeviceBridge/Safety/SpeedBrake.h
	DeviceBridge/Safety/StartInsideLatch.h
	DeviceBridge/Safety/SampleMonitor.h
	DeviceBridge/Timing/Clock.h
	DeviceBridge/Timing/Delegate.h
	DeviceBridge/Timing/MonotonicClock.h
	DeviceBridge/Timing/TripleBuffer.h
	TestSupport/ContactLog.h
	TestSupport/Matchers.h
	TestSupport/TestScenes.h
	TestSupport/TestWorld.h)
# What the path of a header matches that includes Bullet's.
set(BULLETHAPTICS_BULLET_HEADER "/Bullet/|/bt[A-Z]|^TestSupport/")
if(NOT BULLETHAPTICS_BULLET)
	list(FILTER BULLETHAPTICS_HEADERS EXCLUDE REGEX ${BULLETHAPTICS_BULLET_HEADER})
endif()

# Until 0.4: each header can be included by the path that it had in 0.2, before the libraries were split into folders.
function(bullethaptics_forward_old_paths)
	foreach(header ${BULLETHAPTICS_HEADERS})
		string(REGEX REPLACE "^(BulletISTCollision/Core)/[A-Za-z]+/" "\\1/" old ${header})
		string(REGEX REPLACE "^(BulletISTCollision|BulletHapticForce)/(Registry|Contact|PairQuery|Dispatch|Law|Solver|World)/" "\\1/" old ${old})
		string(REGEX REPLACE "^DeviceBridge/(Timing|Device|Loop|Coupling|Bullet|Plugins)/" "DeviceBridge/" old ${old})
		string(REGEX REPLACE "^DeviceBridge/(Safety|Drivers|Hand/Grasp)/(SafetyLimiter|DeviceRegistry|Picture)\\.h$"
			"DeviceBridge/\\2.h" old ${old})
		string(REPLACE "DeviceBridge/Hand/Grasp/" "DeviceBridge/Hand/" old ${old})
		if(NOT old STREQUAL header)
			bullethaptics_forward(${old} ${header})
		endif()
	endforeach()
	bullethaptics_forward(BulletISTCollision/Core/Version.h BulletISTCollision/Core/Base/Version.h)
	# Headers that have another name as well.
	bullethaptics_forward(BulletISTCollision/Core/ForcePromise.h BulletISTCollision/Core/Accuracy/ForceErrorBound.h)
	bullethaptics_forward(BulletISTCollision/Core/PairAccuracy.h BulletISTCollision/Core/Accuracy/AdaptiveLevel.h)
	bullethaptics_forward(BulletISTCollision/Core/PairMemory.h BulletISTCollision/Core/Query/VerletList.h)
	bullethaptics_forward(BulletISTCollision/Core/StepChoice.h BulletISTCollision/Core/Tuning/StableTimeStep.h)
	bullethaptics_forward(BulletISTCollision/btISTEconomy.h BulletISTCollision/Contact/btISTContactCache.h)
	bullethaptics_forward(BulletISTCollision/btISTWatch.h BulletISTCollision/Registry/btISTPairFilter.h)
	bullethaptics_forward(BulletHapticForce/btContactLedger.h BulletHapticForce/Solver/btContactEnergyTank.h)
	bullethaptics_forward(BulletHapticForce/btUnroundedPoses.h BulletHapticForce/Solver/btCompensatedPoses.h)
	bullethaptics_forward(DeviceBridge/Hand/HandWatch.h DeviceBridge/Hand/HandTrackingMonitor.h)
	bullethaptics_forward(DeviceBridge/Safety/StateWatch.h DeviceBridge/Safety/SampleMonitor.h)
endfunction()
function(bullethaptics_forward old header)
	if(NOT BULLETHAPTICS_BULLET AND header MATCHES "${BULLETHAPTICS_BULLET_HEADER}")
		return()
	endif()
	file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/${old}
		CONTENT "// The former path of @header@\n#pragma once\n#include \"@header@\"\n" @ONLY)
	cmake_path(GET old PARENT_PATH folder)
	install(FILES ${PROJECT_BINARY_DIR}/generated/${old} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT dev)
endfunction()
