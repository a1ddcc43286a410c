#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkImageGaussianSmooth.h>
#include <vtkImageResample.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataConnectivityFilter.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "reference/vtk/inrimage.h"
#include "reference/vtk/vtk_tools.h"

namespace palpate::reference {
namespace {

constexpr int kMargin = 12;  // voxels of air around the organ, so that smoothing never meets the border
constexpr float kInside = 100.0F;
constexpr double kPassBand = 0.05;
constexpr int kSincIterations = 20;

/// The box of the mask's voxels, low and high inclusive.
std::array<std::array<int, 3>, 2> mask_box(const std::array<int, 3>& size,
                                           const std::vector<std::uint8_t>& mask) {
  std::array<std::array<int, 3>, 2> box{size, {-1, -1, -1}};
  std::size_t v = 0;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i, ++v) {
        if (mask[v] == 0) continue;
        const std::array<int, 3> at{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          box[0][a] = std::min(box[0][a], at[a]);
          box[1][a] = std::max(box[1][a], at[a]);
        }
      }
    }
  }
  return box;
}

/// The organ's part of the mask as an image of floats; fills in the voxels' volume and centroid.
void copy_mask(const LabelImage& image, const std::vector<std::uint8_t>& mask, vtkImageData* field,
               OrganSurface& organ) {
  const auto box = mask_box(image.size, mask);
  std::array<int, 3> low{};
  std::array<int, 3> count{};
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = box[0][a] - kMargin;
    count[a] = box[1][a] - box[0][a] + 1 + 2 * kMargin;
  }
  field->SetDimensions(count.data());
  field->SetSpacing(image.spacing.data());
  field->SetOrigin(low[0] * image.spacing[0], low[1] * image.spacing[1], low[2] * image.spacing[2]);
  field->AllocateScalars(VTK_FLOAT, 1);
  auto* values = static_cast<float*>(field->GetScalarPointer());
  Vec3 sum;
  double voxels = 0.0;
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        const std::array<int, 3> at{low[0] + i, low[1] + j, low[2] + k};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) inside = inside && at[a] >= 0 && at[a] < image.size[a];
        const std::size_t row = static_cast<std::size_t>(image.size[0]);
        const std::size_t slice = row * static_cast<std::size_t>(image.size[1]);
        inside = inside && mask[static_cast<std::size_t>(at[0]) + row * static_cast<std::size_t>(at[1]) +
                                slice * static_cast<std::size_t>(at[2])] != 0;
        *values++ = inside ? kInside : 0.0F;
        if (!inside) continue;
        voxels += 1.0;
        sum = sum + Vec3{at[0] * image.spacing[0], at[1] * image.spacing[1], at[2] * image.spacing[2]};
      }
    }
  }
  organ.centroid = (1.0 / voxels) * sum;
  organ.voxel_volume = voxels * image.spacing[0] * image.spacing[1] * image.spacing[2];
}

}  // namespace

OrganSurface extract_organ(const std::filesystem::path& path, const OrganOptions& options) {
  if (options.label < 1 || options.label > 255) {
    throw InputError("label", 0, "1 to 255", std::to_string(options.label));
  }
  if (!(options.smoothing > 0.0)) throw InputError("smoothing", 0, "a positive length", "another number");
  if (!(options.spacing > 0.1)) throw InputError("spacing", 0, "more than 0.1", "another number");
  OrganSurface organ;
  vtkNew<vtkImageData> field;
  std::array<double, 3> deviation{};
  {
    const LabelImage image = read_inrimage(path);
    const auto mask = largest_component(image, static_cast<std::uint8_t>(options.label));
    copy_mask(image, mask, field, organ);
    for (std::size_t a = 0; a < 3; ++a) deviation[a] = options.smoothing / image.spacing[a];
  }
  vtkNew<vtkImageGaussianSmooth> smooth;
  smooth->SetInputData(field);
  smooth->SetStandardDeviations(deviation[0], deviation[1], deviation[2]);
  smooth->SetRadiusFactors(3.0, 3.0, 3.0);
  vtkNew<vtkImageResample> resample;  // linear; the smoothed field has no finer detail
  resample->SetInputConnection(smooth->GetOutputPort());
  for (int a = 0; a < 3; ++a) resample->SetAxisOutputSpacing(a, options.spacing);
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputConnection(resample->GetOutputPort());
  contour->SetValue(0, 0.5 * static_cast<double>(kInside));
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  vtkNew<vtkPolyDataConnectivityFilter> largest;
  largest->SetInputConnection(contour->GetOutputPort());
  largest->SetExtractionModeToLargestRegion();
  vtkNew<vtkWindowedSincPolyDataFilter> sinc;
  sinc->SetInputConnection(largest->GetOutputPort());
  sinc->SetNumberOfIterations(kSincIterations);
  sinc->SetPassBand(kPassBand);
  sinc->NormalizeCoordinatesOn();
  sinc->BoundarySmoothingOff();
  sinc->FeatureEdgeSmoothingOff();
  sinc->Update();
  organ.surface = closed_surface_of(sinc->GetOutput(), organ.centroid);
  return organ;
}

}  // namespace palpate::reference
