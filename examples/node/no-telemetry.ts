/** onnxruntime reports to its maker unless this is set before it starts; 0 lets it. */

process.env.ORT_DISABLE_TELEMETRY ||= "1";
